#include "protocol/wire/journal_receiver.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::wire {
namespace {

constexpr double kAskPause_s = 0.005;   // between two requests for the same missing number
constexpr double kGrantPause_s = 0.02;  // credit below a quarter window is given when idle

}  // namespace

JournalReceiver::JournalReceiver(Bus& bus, LivenessMonitor& monitor, int window)
    : bus_(bus),
      monitor_(monitor),
      window_(window),
      credit_every_(std::max(1, window / 4)),
      credit_every_bytes_(unrecorded_bytes(bus.receive_buffer_bytes()) / 4) {
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
      Entry entry = std::move(ready_.front().entry);
      open_ends_message_ = ready_.front().ends_message;
      open_bytes_ = ready_.front().message_bytes;
      ready_.pop_front();
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
  ++steps_since_grant_;
  if (!open_ends_message_) return;
  ++recorded_;
  bytes_since_grant_ += open_bytes_;
  if (steps_since_grant_ >= credit_every_ || bytes_since_grant_ >= credit_every_bytes_ ||
      (finished_ && ready_.empty()))
    grant();
}

void JournalReceiver::on_message(const Header& header, ByteView message) {
  if (header.sequence <= arrived_ || ahead_.contains(header.sequence)) {
    ++duplicates_;
    // The driver repeats what it has no credit for: the credit was lost, or is still to come.
    if (header.sequence <= recorded_) grant();
    return;
  }
  // The driver has at most a window of messages unrecorded, and the last one: this bounds the
  // memory, and whatever has come, there is room for the one that is waited for.
  if (header.sequence > recorded_ + window_ + 1) return bus_.count_undecodable();
  std::vector<Entry> entries = decode(header.kind, message);
  if (entries.empty()) {
    throw Error(ErrorKind::Partner,
                fmt::format("orchestrator: message {} of the journal (macro step {}) cannot be "
                            "decoded: {} speaks another message schema. Install both from one "
                            "build.",
                            header.sequence, header.macro_step, bus_.program_of(header.sender)));
  }
  ahead_.emplace(header.sequence, Message{std::move(entries), message.size()});
  for (auto first = ahead_.begin(); first != ahead_.end() && first->first == arrived_ + 1;
       first = ahead_.erase(first)) {
    ++arrived_;
    take_in(std::move(first->second));
  }
  if (!ahead_.empty()) ask_for_missing(now_s());
}

std::vector<JournalReceiver::Entry> JournalReceiver::decode(Kind kind, ByteView message) const {
  std::vector<Entry> entries;
  if (kind == Kind::Journal) {
    if (auto journals = decode_journal(bus_.share(message))) {
      for (StepJournal& journal : *journals) entries.emplace_back(std::move(journal));
    }
  } else if (auto finished = decode_finished(message)) {
    entries.emplace_back(std::move(*finished));
  }
  return entries;
}

void JournalReceiver::take_in(Message message) {
  for (Entry& entry : message.entries) {
    finished_ = finished_ || std::holds_alternative<Finished>(entry);
    ready_.push_back({std::move(entry), &entry == &message.entries.back(), message.bytes});
  }
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
  steps_since_grant_ = 0;
  bytes_since_grant_ = 0;
  granted_s_ = now_s();
  Bytes message = encode(Credit{bus_.header(Kind::Credit, ++credits_), recorded_, 0});
  bus_.publish(Process::Orchestrator, Kind::Credit, message);
}

}  // namespace tandem::wire
