#pragma once

#include <cstdint>
#include <string_view>

#include "protocol/wire/seal.h"

namespace tandem::wire {

/// LCM's default group. Runs differ in the port.
inline constexpr const char* kGroup = "239.255.76.67";

/// One LCM message as it came in one datagram; valid until the next receive().
struct Datagram {
  std::string_view channel;
  ByteView payload;
  std::uint32_t from_address = 0;  ///< IPv4 address of the sender, host byte order
  std::uint16_t from_port = 0;
};

/// Receiving end of LCM's UDP multicast: a socket bound to the group and one port that reads LCM's
/// small-message format (magic "LC02", sequence, channel, 0, payload).
///
/// Why not lcm_subscribe: liblcm 1.3.1 receives through an own thread and a pipe, which costs three
/// times the round trip; it stalls 10 s when a firewall blocks multicast, turns deaf when the port
/// is taken, and binds to all groups of a port at once. Sending goes through liblcm; other LCM
/// programs (lcm-logger, lcm-spy) hear all messages and can send to us.
class MulticastSocket {
 public:
  /// Throws tandem::Error with the remedy when there is no route or the port is taken.
  MulticastSocket(int port, int receive_buffer_bytes);
  ~MulticastSocket();
  MulticastSocket(const MulticastSocket&) = delete;
  MulticastSocket& operator=(const MulticastSocket&) = delete;

  /// Waits up to `timeout_s` for a datagram. Returns false when none came. A datagram that is not
  /// an LCM message yields an empty channel.
  bool receive(double timeout_s, Datagram& datagram);

  /// Lets the kernel drop what comes from this sender: multicast also returns our own messages,
  /// and each one would wake us for nothing.
  void ignore_sender(std::uint32_t address, std::uint16_t port);

  [[nodiscard]] int receive_buffer_bytes() const { return granted_bytes_; }

 private:
  void open(int port, int receive_buffer_bytes);

  int fd_ = -1;
  int granted_bytes_ = 0;
  Bytes buffer_;
};

/// A multicast port (20000 … 59999) that no process of this host uses at the moment.
[[nodiscard]] int free_port();

}  // namespace tandem::wire
