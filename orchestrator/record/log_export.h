#pragma once

#include <cstdio>
#include <string>

#include "orchestrator/files/run_directory.h"

namespace tandem::orchestrator {

/// Every call of the log as a row: macro_step, iteration, side, kind, accepted, rollback, outcome,
/// t_s (end of the step), then per port the motion and the wrench at the end of the step. For the
/// multibody side the wrench is the input and the motion the output; for the flexible side the
/// reverse.
void export_csv(const RunDirectory& run, std::FILE* out);

/// A few lines about a log: run id, versions, macro steps, calls, how it ends.
[[nodiscard]] std::string describe_log(const RunDirectory& run);

}  // namespace tandem::orchestrator
