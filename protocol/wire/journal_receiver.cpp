#include "protocol/wire/journal_receiver.h"

#include <algorithm>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::wire {
namespace {

constexpr double kAskPause_s = 0.005;    // between two requests for the same missing number
constexpr double kGrantPause_s = 0.02;   // credit below a quarter window is given when idle
constexpr std::size_t kMaxAhead = 4096;  // more than any window: bounds the memory

}  // namespace

JournalReceiver::JournalReceiver(Bus& bus, LivenessMonitor& monitor, int window)
    : bus_(bus), monitor_(monitor), credit_every_(std::max(1, window / 4)) {
  const auto handler = [this](const Header& header, ByteView message) {
    on_message(header, message);
  };
  journals_ = bus_.subscribe(Process::Orchestrator, Kind::Journal, handler);
  finishes_ = bus_.subscribe(Process::Orchestrator, Kind::Finished, handler);
}

std::optional<JournalReceiver::Entry> JournalReceiver::next(double timeout_s) {
  const double end_s = now_s() + timeout_s;
  do {
    const bool arrived =
        monitor_.wait(ready_.empty() ? std::clamp(end_s - now_s(), 0.0, kGrantPause_s) : 0.0);
    if (!ready_.empty()) {
      Entry entry = std::move(ready_.front());
      ready_.pop_front();
      ++handed_;
      return entry;
    }
    if (arrived) continue;
    const double time_s = now_s();
    if (recorded_ > granted_ && time_s - granted_s_ > kGrantPause_s) grant();
    if (!ahead_.empty()) ask_for_missing(time_s);
  } while (now_s() < end_s);
  return std::nullopt;
}

void JournalReceiver::recorded() {
  recorded_ = handed_;
  if (recorded_ - granted_ >= credit_every_ || (finished_ && ready_.empty())) grant();
}

void JournalReceiver::on_message(const Header& header, ByteView message) {
  if (header.sequence <= arrived_ || ahead_.contains(header.sequence)) {
    ++duplicates_;
    // The driver repeats what it has no credit for: the credit was lost, or is still to come.
    if (header.sequence <= recorded_) grant();
    return;
  }
  if (ahead_.size() >= kMaxAhead) return;
  std::optional<Entry> entry;
  if (header.kind == Kind::Journal) {
    if (auto journal = decode_journal(message)) entry = std::move(*journal);
  } else if (auto finished = decode_finished(message)) {
    entry = std::move(*finished);
  }
  if (!entry) return bus_.count_undecodable();
  ahead_.emplace(header.sequence, std::move(*entry));
  for (auto first = ahead_.begin(); first != ahead_.end() && first->first == arrived_ + 1;
       first = ahead_.erase(first)) {
    ++arrived_;
    finished_ = finished_ || std::holds_alternative<Finished>(first->second);
    ready_.push_back(std::move(first->second));
  }
  if (!ahead_.empty()) ask_for_missing(now_s());
}

void JournalReceiver::ask_for_missing(double time_s) {
  if (time_s - asked_s_ < kAskPause_s) return;
  asked_s_ = time_s;
  ++asked_again_;
  Bytes message = encode(Credit{bus_.header(Kind::Credit, ++credits_), recorded_, arrived_ + 1});
  granted_ = recorded_;
  bus_.publish(Process::Orchestrator, Kind::Credit, message);
}

void JournalReceiver::grant() {
  granted_ = recorded_;
  granted_s_ = now_s();
  Bytes message = encode(Credit{bus_.header(Kind::Credit, ++credits_), recorded_, 0});
  bus_.publish(Process::Orchestrator, Kind::Credit, message);
}

}  // namespace tandem::wire
