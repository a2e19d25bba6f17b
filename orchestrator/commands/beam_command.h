#pragma once

#include "fem_process/keys/analysis_keys.h"
#include "orchestrator/commands/fem_command.h"

namespace tandem::orchestrator {

/// `tandem fem` of a scenario whose `fem.model` is ancf: static load steps, eigenfrequencies about
/// the mounted shape, or motion. Displacements are those of the watched points.
[[nodiscard]] FemOutcome run_beams(const scenario::Node& root, const std::string& kind,
                                   const fem::AnalysisParams& params,
                                   const std::filesystem::path& folder);

}  // namespace tandem::orchestrator
