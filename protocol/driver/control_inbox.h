#pragma once

#include <deque>
#include <string>
#include <vector>

#include "protocol/driver/command_source.h"
#include "protocol/wire/bus.h"
#include "protocol/wire/messages.h"

namespace tandem {

/// The driver's end of the control channel: commands that `tandem control` publishes on the bus of
/// the run. A sender repeats its command until it is answered: each is made once, a repetition gets
/// the same answer. The answers to the last 1024 commands are kept for that; 64 at most are open at
/// once, and none is longer than 4096 bytes.
class ControlInbox final : public CommandSource {
 public:
  explicit ControlInbox(wire::Bus& bus);

  [[nodiscard]] std::vector<Command> take() override;
  void answer(const Command& command, std::int64_t macro_step,
              const CommandResult& result) override;

 private:
  void on_control(wire::ByteView message);
  void publish(const wire::Controlled& answer);

  wire::Bus& bus_;
  std::vector<Command> waiting_;
  /// Handed out and not answered yet: the flexible side may take longer than the tool repeats.
  std::vector<std::int64_t> taken_;
  std::deque<wire::Controlled> answered_;
  wire::Subscription controls_;
};

/// The sender's end: publishes `text` until the driver has answered. Throws tandem::Error (Usage)
/// when it is longer than a command can be, and (Partner)
/// when no run is heard on the bus, or its processes fall silent for `timeout_s`.
[[nodiscard]] wire::Controlled send_command(wire::Bus& bus, const std::string& text,
                                            double timeout_s);

}  // namespace tandem
