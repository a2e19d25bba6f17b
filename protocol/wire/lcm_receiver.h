#pragma once

#include <deque>
#include <exception>
#include <memory>
#include <string>

#include "protocol/wire/loopback_route.h"
#include "protocol/wire/receiver.h"

namespace tandem::wire {

/// Receives through lcm_subscribe: a thread of liblcm reads the socket and hands over through a
/// pipe. For comparison, and for hosts where only liblcm's own sockets are let through.
class LcmReceiver final : public Receiver {
 public:
  explicit LcmReceiver(const ReceiverOptions& options);
  ~LcmReceiver() override;
  LcmReceiver(const LcmReceiver&) = delete;
  LcmReceiver& operator=(const LcmReceiver&) = delete;

  bool receive(double timeout_s, Datagram& datagram) override;
  [[nodiscard]] int receive_buffer_bytes() const override { return 0; }

 private:
  struct Message {
    std::string channel;
    Bytes payload;
  };
  struct Lcm;

  LoopbackRoute loopback_;  // before liblcm has sockets
  std::unique_ptr<Lcm> lcm_;
  std::deque<Message> arrived_;
  Message handed_out_;
  std::exception_ptr failure_;  ///< of the callback
};

}  // namespace tandem::wire
