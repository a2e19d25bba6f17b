#pragma once

#include <cstdint>
#include <deque>

#include "protocol/wire/bus.h"
#include "protocol/wire/liveness.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

/// Driver's end of the journal: one message per macro step to the orchestrator, numbered from 1. At
/// most `window` of them may be unrecorded there; the driver then waits, so that the log is
/// complete up to `window` steps behind the run, whatever the wire loses.
class JournalSender {
 public:
  JournalSender(Bus& bus, LivenessMonitor& monitor, int window);
  JournalSender(const JournalSender&) = delete;
  JournalSender& operator=(const JournalSender&) = delete;

  /// Sends the journal of a macro step; blocks first while the window is used up. Returns the time
  /// blocked (s). Throws tandem::Error when the orchestrator is gone.
  double send(const StepJournal& journal);

  /// Says how the run ended and waits until everything is recorded.
  void finish(const Finished& finished);

  [[nodiscard]] std::int64_t resent() const { return resent_; }

 private:
  struct Pending {
    Kind kind{};
    Bytes message;
    std::int32_t attempt = 0;
  };
  void push(Kind kind, Bytes message);
  void wait_until_open(std::size_t limit);
  void resend(std::int64_t number);
  void on_credit(ByteView message);

  Bus& bus_;
  LivenessMonitor& monitor_;
  std::size_t window_;
  std::int64_t recorded_ = 0;    ///< all up to this number are in the log
  std::deque<Pending> pending_;  ///< numbers recorded_ + 1, recorded_ + 2, …
  std::int64_t resent_ = 0;
  Subscription credits_;
};

}  // namespace tandem::wire
