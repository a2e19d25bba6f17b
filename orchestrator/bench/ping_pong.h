#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "orchestrator/files/file_descriptor.h"

namespace tandem::orchestrator {

/// What a ping-pong carries: `there` bytes and `back` bytes, as the request and its reply do.
struct PingPongSizes {
  std::size_t there = 0;
  std::size_t back = 0;
};

/// Two bound sockets of 127.0.0.1 on ports of the kernel's choice. Made before the processes part,
/// so that both ends know the ports.
class PingPongSockets {
 public:
  PingPongSockets();
  PingPongSockets(const PingPongSockets&) = delete;
  PingPongSockets& operator=(const PingPongSockets&) = delete;

  [[nodiscard]] int tcp_listener() const { return tcp_.get(); }
  [[nodiscard]] int udp() const { return udp_.get(); }
  [[nodiscard]] int tcp_port() const;
  [[nodiscard]] int udp_port() const;

 private:
  FileDescriptor tcp_;
  FileDescriptor udp_;
};

/// Answers both kinds of ping in threads of its own until the process ends. They wait in blocking
/// calls: no cost while nobody pings.
void answer_pings(const PingPongSockets& sockets, PingPongSizes sizes);

/// The asking end: blocking sockets, one write and one read each way where the payload fits; TCP
/// with TCP_NODELAY, UDP in datagrams of at most 59,000 bytes.
class PingPong {
 public:
  PingPong(const PingPongSockets& sockets, PingPongSizes sizes);
  PingPong(const PingPong&) = delete;
  PingPong& operator=(const PingPong&) = delete;

  /// Round trips of one block (µs). A UDP round trip that lost a datagram is made again.
  [[nodiscard]] std::vector<double> tcp_us(int count);
  [[nodiscard]] std::vector<double> udp_us(int count);

 private:
  PingPongSizes sizes_;
  FileDescriptor tcp_;
  FileDescriptor udp_;
  std::uint32_t number_ = 0;
  std::vector<char> out_, in_;
};

}  // namespace tandem::orchestrator
