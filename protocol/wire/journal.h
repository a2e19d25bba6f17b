#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/contract/ledger.h"
#include "protocol/contract/subsystem.h"
#include "protocol/wire/call_times.h"
#include "protocol/wire/seal.h"

namespace tandem::wire {

enum class SideName : std::int8_t { Mbs = 0, Fem = 1 };
[[nodiscard]] inline const char* text_of(SideName side) {
  return side == SideName::Mbs ? "mbs" : "fem";
}

enum class CallKind : std::int8_t { Initialize = 0, Advance = 1, Command = 2 };

/// One call of one side as the driver saw it: enough to make the call again and to compare what
/// comes out. Whatever the side, `wrenches` and `motions` hold both of its ends:
///   mbs: input = wrenches.begin, wrenches.end; output = motions.end  (motions.begin is empty)
///   fem: input = motions.begin, motions.end;   output = wrenches.end (wrenches.begin is empty)
/// Initialize has its input in `.end` alone. A Command has its text, and outcome Failed when it was
/// refused.
struct CallRecord {
  SideName side = SideName::Mbs;
  CallKind kind = CallKind::Initialize;
  bool checkpoint_first = false;  ///< checkpoint() was called just before
  bool rollback_first = false;  ///< rollback() was called just before (after a checkpoint, if both)
  bool linearize = false;
  bool accepted = false;        ///< the side's state went on from here; else rolled back
  std::int64_t macro_step = 0;  ///< 0 = initialization, 1 … N = the macro steps
  std::int32_t iteration = 0;   ///< 1 = the side's first advance of the macro step
  SimTime step{};               ///< H
  Segment<WrenchSet> wrenches;
  Segment<MotionSet> motions;
  Outcome outcome = Outcome::Done;
  std::string message;  ///< empty when Done; of a command: what was done, or why not
  std::int32_t solver_iterations = 0;
  std::string command;  ///< Command: its text
  CallTimes times;      ///< not of a log of protocol version 7
};

/// Why the values of a call do not fit a run of so many ports; empty = they do. The begin of a
/// received call may have been left out.
[[nodiscard]] std::string misfit(const CallRecord& call, std::size_t ports,
                                 bool may_lack_begin = false);

/// The last accepted input of each side, to be told of every call in order. There the segments of
/// the side's next calls begin: those that do, bit for bit, travel and are logged without their
/// begin.
class AcceptedInputs {
 public:
  /// Whether the call is an advance that begins there.
  [[nodiscard]] bool is_begin_of(const CallRecord& call) const;
  /// Gives an advance its begin when that was left out.
  void complete(CallRecord& call) const;
  void follow(const CallRecord& call);
  void follow(CallRecord&& call);

 private:
  WrenchSet wrenches_;
  MotionSet motions_;
};

/// One macro step as the scheme ended it. Macro step 0 carries the initialization.
struct StepRecord {
  std::int64_t macro_step = 0;
  SimTime time{};  ///< at the end of the step
  SimTime step{};  ///< H
  std::int32_t iterations = 0;
  double residual_N = 0.0;
  double energy_defect_J = 0.0;
  Outcome outcome = Outcome::Done;
  Ledger ledger;                       ///< of this step
  std::optional<SideEnergies> energy;  ///< at its end, where it was observed
};

/// The events of a macro step as they were encoded by the driver, in the message that brought them.
/// The log takes these bytes, and writes its own headers into them.
struct ReceivedEvents {
  std::shared_ptr<Bytes> message;               ///< null = the step was not received but made here
  std::vector<std::span<std::uint8_t>> events;  ///< one a call, then the step's record
};

/// Everything that happened in one macro step: what travels to the orchestrator and into the log.
struct StepJournal {
  StepRecord step;
  std::vector<CallRecord> calls;  ///< in the order they were made, discarded ones too
  ReceivedEvents received = {};   ///< the same once more, where it came over the wire
};

/// Bytes of journals that may be unrecorded: as many as a receive buffer of this size (0 = not
/// known) holds while the orchestrator writes.
[[nodiscard]] std::size_t unrecorded_bytes(int receive_buffer_bytes);

/// How the run ended, said once by the driver.
struct Finished {
  int exit_code = 0;
  std::string message;       ///< one line for the user
  std::string summary_json;  ///< numbers of the driver for summary.json
};

}  // namespace tandem::wire
