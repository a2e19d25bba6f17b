#pragma once

#include "orchestrator/run/run.h"

namespace tandem::orchestrator {

/// Launches both sides as processes, lets the driver run the scheme, records, supervises, and ends
/// everything that it started. Returns what the driver said; throws tandem::Error when a process
/// failed or stopped answering, after all of them have ended.
[[nodiscard]] wire::Finished run_over_lcm(const Model& model, const RunDirectory& directory,
                                          const RunOptions& options, std::uint64_t run_id,
                                          Recorder& recorder);

}  // namespace tandem::orchestrator
