#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "orchestrator/files/run_directory.h"
#include "orchestrator/run/progress.h"
#include "orchestrator/run/step_tables.h"
#include "orchestrator/scenario/model.h"
#include "protocol/driver/coupled_run.h"
#include "protocol/wire/event_log.h"

namespace tandem::orchestrator {

/// Writes everything that a run leaves behind, macro step by macro step: exchange.lcm, steps.csv
/// and ports.csv. A step of the log that record() has returned from is readable even if this
/// process dies next.
class Recorder final : public StepSink {
 public:
  Recorder(const Model& model, const RunDirectory& directory, std::uint64_t run_id, bool silent);

  /// Throws once a signal has asked to stop; the step is recorded then, too.
  double record(wire::StepJournal journal) override;
  void rest(double seconds) override;

  /// Closes the log with how the run ended; a log that could not be written to stays as it is.
  void finish(const wire::Finished& finished);

  /// Flushes the tables and ends the progress line; to be called also when the run failed.
  void flush();
  void end_progress() { progress_.finish(); }

  [[nodiscard]] std::int64_t recorded_steps() const { return recorded_steps_; }

  /// What the recorded macro steps tell of a run that was broken off.
  [[nodiscard]] const RunReport& so_far() const { return so_far_; }

  /// Also hand the accepted interface of every macro step to `watch` (comparisons).
  using Watch = std::function<void(const AcceptedInterface&)>;
  void watch(Watch watch) { watch_ = std::move(watch); }

 private:
  void book(const wire::StepRecord& step, AcceptedInterface accepted);
  [[nodiscard]] bool logs(const wire::StepJournal& journal) const;

  wire::LogWriter log_;
  std::int64_t log_every_steps_;  ///< 0: the scenario and the end alone
  bool log_is_whole_ = true;      ///< it ends with a whole event
  StepTables tables_;
  Progress progress_;
  Watch watch_;
  std::int64_t recorded_steps_ = 0;
  RunReport so_far_;
};

}  // namespace tandem::orchestrator
