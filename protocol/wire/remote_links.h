#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "protocol/wire/bus.h"
#include "protocol/wire/liveness.h"
#include "protocol/wire/remote_link.h"

namespace tandem::wire {

/// The links of one driver to several sides. Requests that are begun one after the other leave in
/// one message to all sides, as they would have left alone: each keeps its link's number and its
/// flags, so that what a side does with it, and what a link does when the reply stays away, are the
/// same. An evaluation of N sides is 1 + N messages, not 2 N.
///
/// Whichever reply is waited for, all are taken in and the time-outs of all run: a request of any
/// side that is late is repeated to that side alone.
class RemoteLinks {
 public:
  RemoteLinks(Bus& bus, LivenessMonitor& monitor);
  ~RemoteLinks();
  RemoteLinks(const RemoteLinks&) = delete;
  RemoteLinks& operator=(const RemoteLinks&) = delete;

  /// One more; both live until no call is made any more.
  void add(RemoteLink& link);

  /// The link's request is encoded. It is sent with the last of all links', or by send().
  void begun(RemoteLink& link);

  /// Sends what has begun: in one message where that fits one datagram, a single one as if its link
  /// were the only one.
  void send();

  /// Waits for the reply to this one.
  void await(const RemoteLink& link);

 private:
  [[nodiscard]] bool fits_one() const;
  void send_together();
  [[nodiscard]] std::string state_of(Process side) const;

  Bus& bus_;
  LivenessMonitor& monitor_;
  std::vector<RemoteLink*> links_;
  std::vector<RemoteLink*> begun_;  ///< not sent yet
  std::int64_t sequence_ = 0;
  Bytes message_;  ///< its memory serves every call
};

}  // namespace tandem::wire
