#include "protocol/wire/journal_sender.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"
#include "protocol/wire/resend_timeouts.h"

namespace tandem::wire {
namespace {

constexpr double kLongestStay_s = 0.005;
constexpr std::size_t kLargestBatch = 30000;  // so that it and one step more fit one datagram

}  // namespace

JournalSender::JournalSender(Bus& bus, LivenessMonitor& monitor, int window, bool whole_log)
    : bus_(bus),
      monitor_(monitor),
      window_(static_cast<std::size_t>(window)),
      most_bytes_(unrecorded_bytes(bus.receive_buffer_bytes())),
      whole_log_(whole_log) {
  require(window >= 1, "wire: a credit window of " + std::to_string(window) +
                           " macro steps lets no step be made. Give at least 1.");
  credits_ = bus_.subscribe(Process::Orchestrator, Kind::Credit,
                            [this](const Header&, ByteView message) { on_credit(message); });
  monitor_.also_watch([this] {
    if (now_s() - flushed_s_ > kLongestStay_s) flush();
  });
}

JournalSender::~JournalSender() {
  monitor_.also_watch({});
  try {
    flush();
  } catch (const std::exception&) {
    return;  // the run is failing: what ends it is said by whoever threw first
  }
}

double JournalSender::send(StepJournal journal) {
  // Credit that has come in meanwhile costs no waiting; it need not be looked for in every step.
  if (2 * open_steps_ >= window_ || 2 * open_bytes_ >= most_bytes_) {
    while (monitor_.wait(0.0)) {
    }
  }
  const double begin_s = now_s();
  const auto has_room = [this] { return open_steps_ < window_ && open_bytes_ < most_bytes_; };
  if (!has_room()) {
    flush();
    wait_until(has_room);
  }
  const double time_s = now_s();
  if (batch_.steps == 0) {
    if (!spare_.empty()) {
      batch_.message = std::move(spare_.back());
      spare_.pop_back();
    }
    begin_journal(batch_.message);
  }
  macro_step_ = journal.step.macro_step;
  if (whole_log_) {
    append(std::move(journal), accepted_, batch_.message);
  } else {
    append(journal, batch_.message);
  }
  ++batch_.steps;
  ++open_steps_;
  if (8 * batch_.steps >= window_ || batch_.message.size() > kLargestBatch ||
      time_s - flushed_s_ > kLongestStay_s) {
    flush();
  }
  return time_s - begin_s;
}

void JournalSender::finish(const Finished& finished) {
  flush();
  push({.kind = Kind::Finished,
        .message = encode(bus_.header(Kind::Finished, next_number()), finished)});
  wait_until([this] { return pending_.empty(); });
}

std::int64_t JournalSender::next_number() const {
  return recorded_ + static_cast<std::int64_t>(pending_.size()) + 1;
}

void JournalSender::flush() {
  flushed_s_ = now_s();
  if (batch_.steps == 0) return;
  Header header = bus_.header(Kind::Journal, next_number());
  header.macro_step = macro_step_;
  end_journal(header, batch_.message);
  batch_.kind = Kind::Journal;
  push(std::exchange(batch_, {}));
}

void JournalSender::push(Pending pending) {
  Pending& last = pending_.emplace_back(std::move(pending));
  open_bytes_ += last.message.size();
  bus_.publish(Process::Orchestrator, last.kind, last.message);
}

void JournalSender::wait_until(const std::function<bool()>& done) {
  double timeout_s = kFirstTimeout_s;
  double resend_s = now_s() + timeout_s;
  std::int64_t recorded = recorded_;
  while (!done()) {
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
    open_steps_ -= pending_.front().steps;
    open_bytes_ -= pending_.front().message.size();
    spare_.push_back(std::move(pending_.front().message));
    pending_.pop_front();
    ++recorded_;
  }
  if (credit->wanted > 0) resend(credit->wanted);
}

}  // namespace tandem::wire
