#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <optional>
#include <string>

#include "protocol/wire/bus.h"
#include "protocol/wire/handshake.h"
#include "protocol/wire/liveness.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

struct ServerOptions {
  std::uint64_t scenario_hash = 0;
  std::string tandem_version;
  double linger_s = 1.0;           ///< longest time to answer a repeated bye
  Heartbeat* heartbeat = nullptr;  ///< is told phase and macro step, when given
};

/// Server end of the exchange. Executes each request number exactly once and in order; repeats the
/// encoded reply when the last number comes again; passes over older ones; a gap is an error.
class RequestServer {
 public:
  /// Makes the call, may take the values of the request, and fills output, outcome, message,
  /// Jacobian or observation of the reply. May throw: the text travels to the client, and run()
  /// throws it again here.
  using Execute = std::function<void(Request&, Reply&)>;

  /// Serves the side named by the bus's own process.
  RequestServer(Bus& bus, LivenessMonitor& monitor, ServerOptions options,
                const SubsystemInfo& info, Execute execute);

  /// Until the client's bye. Throws tandem::Error when the client or another partner falls silent
  /// or fails, when the handshake does not fit, and what `execute` threw.
  void run();

  /// Requests that came again or too late, and how many were executed.
  [[nodiscard]] std::int64_t duplicates() const { return duplicates_; }
  [[nodiscard]] std::int64_t executed() const { return last_; }

 private:
  void look_at(const HelloServer& hello);
  void on_request(const Header& header, ByteView message);
  void on_requests(ByteView message);
  void execute(ByteView message);
  void publish_reply(Reply& reply);
  void repeat_reply();

  Bus& bus_;
  LivenessMonitor& monitor_;
  ServerOptions options_;
  const SubsystemInfo& info_;
  Execute execute_;
  Request request_;        ///< decoded; its memory serves every request
  std::int64_t last_ = 0;  ///< number of the last request executed
  Bytes reply_;            ///< its encoded reply
  double reply_s_ = 0.0;   ///< when it was last published
  std::int32_t repeats_ = 0;
  double publish_cost_s_ = 0.0;  ///< of the previous reply
  std::int64_t duplicates_ = 0;
  bool greeted_ = false;
  bool done_ = false;    ///< bye was answered
  bool closed_ = false;  ///< the client has heard the answer
  std::exception_ptr failure_;
};

}  // namespace tandem::wire
