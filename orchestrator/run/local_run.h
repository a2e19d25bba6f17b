#pragma once

#include "orchestrator/run/run.h"
#include "protocol/driver/run_report.h"

namespace tandem::orchestrator {

/// Both sides as objects of this process; mode Inproc or Monolithic.
[[nodiscard]] RunReport run_here(const Model& model, const RunDirectory& directory, Mode mode,
                                 Recorder& recorder);

}  // namespace tandem::orchestrator
