#include "protocol/wire/journal_sender.h"

#include <algorithm>
#include <utility>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::wire {
namespace {

constexpr double kFirstTimeout_s = 0.02;
constexpr double kLastTimeout_s = 0.2;

}  // namespace

JournalSender::JournalSender(Bus& bus, LivenessMonitor& monitor, int window)
    : bus_(bus), monitor_(monitor), window_(static_cast<std::size_t>(window)) {
  require(window >= 1, "wire: a credit window of " + std::to_string(window) +
                           " macro steps lets no step be made. Give at least 1.");
  credits_ = bus_.subscribe(Process::Orchestrator, Kind::Credit,
                            [this](const Header&, ByteView message) { on_credit(message); });
}

double JournalSender::send(const StepJournal& journal) {
  // Credit that has come in meanwhile costs no waiting.
  while (!pending_.empty() && monitor_.wait(0.0)) {
  }
  const double begin_s = now_s();
  if (pending_.size() >= window_) wait_until_open(window_ - 1);
  const double blocked_s = now_s() - begin_s;
  const std::int64_t number = recorded_ + static_cast<std::int64_t>(pending_.size()) + 1;
  push(Kind::Journal, encode(bus_.header(Kind::Journal, number), journal));
  return blocked_s;
}

void JournalSender::finish(const Finished& finished) {
  const std::int64_t number = recorded_ + static_cast<std::int64_t>(pending_.size()) + 1;
  push(Kind::Finished, encode(bus_.header(Kind::Finished, number), finished));
  wait_until_open(0);
}

void JournalSender::push(Kind kind, Bytes message) {
  Pending& pending = pending_.emplace_back(Pending{kind, std::move(message)});
  bus_.publish(Process::Orchestrator, kind, pending.message);
}

void JournalSender::wait_until_open(std::size_t limit) {
  double timeout_s = kFirstTimeout_s;
  double resend_s = now_s() + timeout_s;
  std::int64_t recorded = recorded_;
  while (pending_.size() > limit) {
    monitor_.wait(std::max(0.0, resend_s - now_s()));
    if (recorded_ > recorded) {
      recorded = recorded_;
      timeout_s = kFirstTimeout_s;
      resend_s = now_s() + timeout_s;
    } else if (now_s() >= resend_s) {
      // Either the oldest or its credit is lost; the newest tells the recorder of gaps between.
      resend(recorded_ + 1);
      if (pending_.size() > 1) resend(recorded_ + static_cast<std::int64_t>(pending_.size()));
      timeout_s = std::min(2.0 * timeout_s, kLastTimeout_s);
      resend_s = now_s() + timeout_s;
    }
  }
}

void JournalSender::resend(std::int64_t number) {
  const std::int64_t index = number - recorded_ - 1;
  if (index < 0 || index >= static_cast<std::int64_t>(pending_.size())) return;
  Pending& pending = pending_[static_cast<std::size_t>(index)];
  bus_.publish(Process::Orchestrator, pending.kind, pending.message, ++pending.attempt);
  ++resent_;
}

void JournalSender::on_credit(ByteView message) {
  const auto credit = decode_credit(message);
  if (!credit) return bus_.count_undecodable();
  while (recorded_ < credit->recorded_through && !pending_.empty()) {
    pending_.pop_front();
    ++recorded_;
  }
  if (credit->wanted > 0) resend(credit->wanted);
}

}  // namespace tandem::wire
