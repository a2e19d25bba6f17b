#pragma once

#include <linux/filter.h>

#include <cstdint>
#include <string>
#include <vector>

namespace tandem::wire {

/// What a socket of a run needs not be woken for.
struct ChannelFilter {
  std::uint32_t own_address = 0;      ///< IPv4, host byte order; with own_port = 0: not known
  std::uint16_t own_port = 0;         ///< messages from here are our own
  std::string prefix;                 ///< of all channels of the run
  std::vector<std::string> channels;  ///< wanted ones; all begin with the prefix
};

/// A socket filter (classic BPF, run by the kernel before the datagram is queued) for LCM's small
/// messages: drops our own ones, and those on channels of this run that are not wanted. Messages of
/// other programs pass: they are counted. Each process hears all multicast of the run's port, and
/// without this would wake for the exchange of the other two.
[[nodiscard]] std::vector<sock_filter> compile(const ChannelFilter& filter);

}  // namespace tandem::wire
