#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "protocol/wire/bus.h"
#include "protocol/wire/liveness.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

/// Orchestrator's end of the journal: hands out every macro step exactly once and in order, asks
/// for what is missing, and gives the driver credit only for what recorded() has confirmed.
///
///   while (auto entry = …next(0.1)) { log.write(*entry); receiver.recorded(); }
///
/// Go on calling next() until the driver's process has ended: the last credit may be lost.
class JournalReceiver {
 public:
  using Entry = std::variant<StepJournal, Finished>;

  /// `window` as in JournalSender: credit is given four times per window or receive
  /// buffer, and when nothing comes.
  JournalReceiver(Bus& bus, LivenessMonitor& monitor, int window);
  JournalReceiver(const JournalReceiver&) = delete;
  JournalReceiver& operator=(const JournalReceiver&) = delete;

  /// The next entry, waiting up to `timeout_s` for it. One entry is open until recorded().
  std::optional<Entry> next(double timeout_s);

  /// The entry handed out last is safely on disk.
  void recorded();

  [[nodiscard]] std::int64_t duplicates() const { return duplicates_; }
  [[nodiscard]] std::int64_t asked_again() const { return asked_again_; }

 private:
  /// An entry, and whether it is the last one of its message.
  struct Ready {
    Entry entry;
    bool ends_message = false;
    std::size_t message_bytes = 0;
  };
  struct Message {
    std::vector<Entry> entries;
    std::size_t bytes = 0;
  };

  void on_message(const Header& header, ByteView message);
  [[nodiscard]] std::vector<Entry> decode(Kind kind, ByteView message) const;
  void take_in(Message message);
  void ask_for_missing(double time_s);
  void grant();

  Bus& bus_;
  LivenessMonitor& monitor_;
  std::int64_t window_;
  std::int64_t credit_every_;
  std::size_t credit_every_bytes_;
  std::int64_t arrived_ = 0;   ///< all messages up to this number have arrived
  std::int64_t recorded_ = 0;  ///< confirmed by recorded()
  std::int64_t granted_ = 0;   ///< told to the driver
  std::int64_t steps_since_grant_ = 0;
  std::size_t bytes_since_grant_ = 0;
  bool open_ends_message_ = false;  ///< of the entry handed out last
  std::size_t open_bytes_ = 0;      ///< of its message
  std::deque<Ready> ready_;
  std::map<std::int64_t, Message> ahead_;  ///< arrived before an earlier one
  double asked_s_ = 0.0;
  double granted_s_ = 0.0;
  std::int64_t credits_ = 0;
  std::int64_t duplicates_ = 0;
  std::int64_t asked_again_ = 0;
  bool finished_ = false;
  Subscription journals_, finishes_;
};

}  // namespace tandem::wire
