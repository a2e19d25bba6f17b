#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "protocol/wire/bus.h"
#include "protocol/wire/liveness.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

/// Driver's end of the journal: numbered messages to the orchestrator, each with the journals of
/// one or more macro steps. At most `window` macro steps may be unrecorded there; the driver then
/// waits, so that the log is complete up to `window` steps behind the run, whatever the wire loses;
/// and no more bytes than the receive buffer holds, beyond which the kernel would lose them.
///
/// Steps that follow each other quickly travel together, up to an eighth of the window: a message
/// costs the driver as much as the exchange of a small model, and wakes the orchestrator. No step
/// stays here for longer than 5 ms of stepping, or 20 ms of waiting for a partner.
class JournalSender {
 public:
  /// `whole_log`: every macro step is logged, so that calls can leave out what earlier ones hold.
  JournalSender(Bus& bus, LivenessMonitor& monitor, int window, bool whole_log = true);
  ~JournalSender();  ///< what was not sent yet still is: the run may be failing
  JournalSender(const JournalSender&) = delete;
  JournalSender& operator=(const JournalSender&) = delete;

  /// Sends the journal of a macro step; blocks first while the window is used up. Returns the time
  /// blocked (s). Throws tandem::Error when the orchestrator is gone.
  double send(StepJournal journal);

  /// Says how the run ended and waits until everything is recorded.
  void finish(const Finished& finished);

  [[nodiscard]] std::int64_t resent() const { return resent_; }

 private:
  struct Pending {
    Kind kind{};
    Bytes message;
    std::size_t steps = 0;
    std::int32_t attempt = 0;
  };
  void flush();
  void push(Pending pending);
  [[nodiscard]] std::int64_t next_number() const;
  void wait_until(const std::function<bool()>& done);
  void resend(std::int64_t number);
  void on_credit(ByteView message);

  Bus& bus_;
  LivenessMonitor& monitor_;
  std::size_t window_;
  std::size_t most_bytes_;
  bool whole_log_;
  AcceptedInputs accepted_;      ///< of the steps appended
  Pending batch_;                ///< not sent yet
  std::int64_t macro_step_ = 0;  ///< the last one in it
  double flushed_s_ = 0.0;
  std::int64_t recorded_ = 0;    ///< all messages up to this number are in the log
  std::deque<Pending> pending_;  ///< numbers recorded_ + 1, recorded_ + 2, …
  std::size_t open_steps_ = 0;   ///< in them and in the batch
  std::size_t open_bytes_ = 0;   ///< in them
  std::vector<Bytes> spare_;     ///< memory of recorded messages
  std::int64_t resent_ = 0;
  Subscription credits_;
};

}  // namespace tandem::wire
