#pragma once

#include <cstdint>
#include <string_view>

#include "protocol/wire/poll_budget.h"
#include "protocol/wire/seal.h"

namespace tandem::wire {

/// LCM's default group. Runs differ in the port.
inline constexpr const char* kGroup = "239.255.76.67";

/// One LCM message as it came in one datagram; valid until the next receive().
struct Datagram {
  std::string_view channel;
  ByteView payload;
  std::uint32_t from_address = 0;  ///< IPv4 address of the sender, host byte order; 0 = not known
  std::uint16_t from_port = 0;
};

/// How a process listens to the run's multicast. The same bytes come in either way.
enum class Receive {
  Own,  ///< a socket of our own, read by the thread that waits for the message
  Lcm,  ///< lcm_subscribe: liblcm's receive thread and pipe
};

struct ReceiverOptions {
  int port = 0;
  int ttl = 0;
  int receive_buffer_bytes = 4194304;
  Wait wait = Wait::Block;
};

/// Receiving end of LCM's UDP multicast. Constructors throw tandem::Error with the remedy when
/// there is no route or the port is taken.
class Receiver {
 public:
  virtual ~Receiver() = default;

  /// Waits up to `timeout_s`, possibly a little longer, for a datagram. Returns false when none
  /// came. A datagram that is not an LCM message yields an empty channel.
  virtual bool receive(double timeout_s, Datagram& datagram) = 0;

  /// What the kernel granted; 0 = not known.
  [[nodiscard]] virtual int receive_buffer_bytes() const = 0;
};

/// A multicast port (20000 … 59999) that no process of this host uses at the moment.
[[nodiscard]] int free_port();

/// Throws tandem::Error with the remedy when no route leads to the group: liblcm then says "No
/// route" with a garbage address and goes on.
void require_multicast_route(int port);

}  // namespace tandem::wire
