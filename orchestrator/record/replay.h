#pragma once

#include <cstdint>
#include <string>

#include "orchestrator/files/run_directory.h"
#include "orchestrator/run/run.h"

namespace tandem::orchestrator {

struct ReplayOptions {
  std::string side = "fem";  ///< mbs, fem: the whole side; or one of several worlds or bodies
  Mode mode = Mode::Lcm;     ///< Lcm: a real side process; Inproc: the side as an object
  /// Allowed difference: |replayed − logged| ≤ tolerance · max(1, |logged|); 0 = the same bits.
  double tolerance = 0.0;
};

struct ReplayReport {
  std::int64_t macro_steps = 0;
  std::int64_t calls = 0;
  std::int64_t discarded_calls = 0;  ///< of these, rolled back later
  std::string difference;  ///< first one: macro step, iteration, port, component, both values
  std::string remark;      ///< the recorded run did not end as planned: where and why
};

/// Drives one side with the inputs that the log of a run holds for it, in the order of the run and
/// with its checkpoints and rollbacks, and compares every output with the log. Stops at the first
/// difference. The other side is not needed. A damaged log throws a Usage error that names the
/// event and the macro step, and so does a log without a macro step.
/// Throws a Usage error when the run was recorded with output.log_every_steps other than 1.
void require_whole_log(const RunDirectory& run);

[[nodiscard]] ReplayReport replay(const RunDirectory& run, const ReplayOptions& options);

}  // namespace tandem::orchestrator
