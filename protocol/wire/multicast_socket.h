#pragma once

#include <netinet/in.h>

#include <cstddef>

#include "protocol/wire/channel_filter.h"
#include "protocol/wire/receiver.h"

namespace tandem::wire {

/// A socket bound to the group and one port that reads LCM's small-message format (magic "LC02",
/// sequence, channel, 0, payload) in the thread that waits for the message.
///
/// Why not lcm_subscribe: liblcm 1.3.1 receives through an own thread and a pipe, which costs three
/// times the round trip; it stalls 10 s when a firewall blocks multicast, turns deaf when the port
/// is taken, and binds to all groups of a port at once. Sending goes through liblcm; other LCM
/// programs (lcm-logger, lcm-spy) hear all messages and can send to us.
class MulticastSocket final : public Receiver {
 public:
  explicit MulticastSocket(const ReceiverOptions& options);
  ~MulticastSocket() override;
  MulticastSocket(const MulticastSocket&) = delete;
  MulticastSocket& operator=(const MulticastSocket&) = delete;

  bool receive(double timeout_s, Datagram& datagram) override;

  /// Lets the kernel drop what is not wanted, before it would wake this process.
  void attach(const ChannelFilter& filter);

  [[nodiscard]] int receive_buffer_bytes() const override { return granted_bytes_; }

 private:
  void open(const ReceiverOptions& options);
  void join(int ttl);
  void set_timeout(double timeout_s);
  /// Bytes of the next datagram; below zero: none came.
  std::ptrdiff_t take(int flags, sockaddr_in& from);
  std::ptrdiff_t poll(double begin_s, double budget_s, sockaddr_in& from);
  std::ptrdiff_t wait(double timeout_s, sockaddr_in& from);

  int fd_ = -1;
  int granted_bytes_ = 0;
  double timeout_s_ = 0.0;  ///< as the socket has it
  PollBudget budget_;
  Bytes buffer_;
};

}  // namespace tandem::wire
