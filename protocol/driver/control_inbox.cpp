#include "protocol/driver/control_inbox.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"
#include "protocol/wire/liveness.h"

namespace tandem {
namespace {

using wire::Kind;
using wire::Process;

// Far more than are made between two repetitions of a sender that has not heard its answer.
constexpr std::size_t kAnswersKept = 1024;
constexpr std::size_t kMostOpen = 64;
constexpr std::size_t kLongestText = 4096;
constexpr double kRepeat_s = 0.05;

}  // namespace

ControlInbox::ControlInbox(wire::Bus& bus) : bus_(bus) {
  controls_ =
      bus.subscribe(Process::Fem, Kind::Control,
                    [this](const wire::Header&, wire::ByteView message) { on_control(message); });
}

void ControlInbox::on_control(wire::ByteView message) {
  auto control = wire::decode_control(message);
  if (!control || control->text.size() > kLongestText) {
    bus_.count_undecodable();
    return;
  }
  const std::int64_t number = control->header.sequence;
  for (const wire::Controlled& answer : answered_) {
    if (answer.header.sequence == number) return publish(answer);
  }
  const bool known = std::any_of(waiting_.begin(), waiting_.end(),
                                 [&](const Command& c) { return c.number == number; }) ||
                     std::find(taken_.begin(), taken_.end(), number) != taken_.end();
  // What finds no room is repeated by its sender.
  if (waiting_.size() + taken_.size() >= kMostOpen) return;
  if (!known) waiting_.push_back({number, std::move(control->text)});
}

std::vector<Command> ControlInbox::take() {
  for (const Command& command : waiting_) taken_.push_back(command.number);
  return std::exchange(waiting_, {});
}

void ControlInbox::answer(const Command& command, std::int64_t macro_step,
                          const CommandResult& result) {
  wire::Controlled answer{.header = bus_.header(Kind::Controlled, command.number),
                          .accepted = result.accepted,
                          .message = result.message};
  answer.header.macro_step = macro_step;
  publish(answer);
  answered_.push_back(std::move(answer));
  std::erase(taken_, command.number);
  if (answered_.size() > kAnswersKept) answered_.pop_front();
}

void ControlInbox::publish(const wire::Controlled& answer) {
  wire::Bytes bytes = wire::encode(answer);
  bus_.publish(Process::Tool, Kind::Controlled, bytes);
}

wire::Controlled send_command(wire::Bus& bus, const std::string& text, double timeout_s) {
  require(text.size() <= kLongestText, "control: a command has at most 4096 bytes.");
  const auto number = static_cast<std::int64_t>(wire::random_run_id() >> 1U);
  std::optional<wire::Controlled> answer;
  const wire::Subscription answers = bus.subscribe(
      Process::Tool, Kind::Controlled, [&](const wire::Header& header, wire::ByteView message) {
        if (header.sequence == number) answer = wire::decode_controlled(message);
      });
  // The orchestrator lives as long as its run does, whoever drives it.
  wire::LivenessMonitor monitor(bus, {Process::Orchestrator}, timeout_s);
  wire::Bytes bytes =
      wire::encode(wire::Control{.header = bus.header(Kind::Control, number), .text = text});
  double repeat_s = 0.0;
  for (std::int32_t attempt = 0; !answer;) {
    if (now_s() >= repeat_s) {
      bus.publish(Process::Fem, Kind::Control, bytes, attempt++);
      repeat_s = now_s() + kRepeat_s;
    }
    monitor.wait(kRepeat_s);
  }
  return *answer;
}

}  // namespace tandem
