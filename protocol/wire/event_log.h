#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>

#include "protocol/wire/journal.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

/// The exchange log (exchange.lcm): an LCM event log, readable by lcm-logplayer and lcm-spy.
///   event 0            TANDEM_<run>_orchestrator_scenario  resolved scenario, versions
///   one per call       TANDEM_<run>_<side>_call            in the order they were made
///   one per macro step TANDEM_<run>_orchestrator_step      behind its calls
///   last event         TANDEM_<run>_orchestrator_finished  missing = the run or the file was cut
/// Header sequence = event number, header time = event time stamp, so that every byte of an event
/// is either covered by the checksum or checked against what is.
class LogWriter {
 public:
  /// Throws tandem::Error with the file's name when it cannot be written.
  LogWriter(const std::filesystem::path& file, std::uint64_t run_id, const ScenarioText& scenario);
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// Writes and flushes to the operating system: readable even if this process is killed next.
  /// What was received is written as it came, with this log's headers; the rest is encoded, calls
  /// without a begin that the log holds already. One log takes steps of one of both kinds.
  void write(const StepJournal& journal);
  void write(const Finished& finished);

  /// Throws when the file was removed while it was written: what follows would be lost.
  void require_still_there() const;

  [[nodiscard]] std::int64_t bytes() const { return bytes_; }

 private:
  struct File;
  [[nodiscard]] Header next_header(Kind kind);
  template <class Record>
  void event(Process topic, Kind kind, const Record& record);
  void event(Process topic, Kind kind, std::span<std::uint8_t> received);
  void event(const CallRecord& call);
  void put(Process topic, const Header& header, std::span<std::uint8_t> message);
  void flush();
  [[noreturn]] void fail() const;

  std::unique_ptr<File> file_;
  std::string name_;
  std::uint64_t run_id_;
  AcceptedInputs accepted_;  ///< of the calls encoded here
  Bytes message_;            ///< of the event being written
  std::int64_t number_ = 0;
  std::int64_t bytes_ = 0;
};

/// Reads an exchange log event by event.
class LogReader {
 public:
  using Event = std::variant<CallRecord, StepRecord, Finished>;

  /// Throws tandem::Error (Usage) when the file is missing, is no exchange log, or its first event
  /// is damaged.
  explicit LogReader(const std::filesystem::path& file);

  [[nodiscard]] const ScenarioText& scenario() const { return scenario_; }
  [[nodiscard]] std::uint64_t run_id() const { return run_id_; }

  /// The next event, complete, or nothing at the end. Throws tandem::Error (Usage) naming event
  /// number and macro step when the event is damaged. A last event that is cut short ends the log.
  std::optional<Event> next();

  /// All calls and the record of the next macro step; nothing at the end, or when the log was cut
  /// before the step's record.
  std::optional<StepJournal> next_step();

  /// After the end: how the run ended, if the log has its last event.
  [[nodiscard]] const std::optional<Finished>& finished() const { return finished_; }

  /// After the end: the last event is cut short or missing.
  [[nodiscard]] bool truncated() const { return !finished_.has_value(); }

  /// As found in the file, for publishing it again.
  struct RawEvent {
    std::int64_t time_us = 0;
    std::string channel;
    Bytes payload;
    Header header;
  };
  /// As next(), undecoded; the first event is the scenario unless next() was called before.
  std::optional<RawEvent> next_raw();

 private:
  [[noreturn]] void fail(const std::string& what) const;
  /// Whether the next event's sync word and number stand somewhere behind here.
  [[nodiscard]] bool another_event_follows();

  std::string name_;
  std::ifstream file_;
  std::int64_t size_ = 0;
  std::int64_t number_ = 0;
  bool at_end_ = false;           ///< the event being read reaches to the end of the file
  std::int64_t macro_step_ = -1;  ///< the last one read whole
  AcceptedInputs accepted_;       ///< as the calls read so far say
  std::uint64_t run_id_ = 0;
  ScenarioText scenario_;
  std::optional<Finished> finished_;
};

}  // namespace tandem::wire
