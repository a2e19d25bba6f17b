#pragma once

#include <filesystem>
#include <vector>

#include "orchestrator/advise/interface_ratios.h"
#include "orchestrator/advise/load_trial.h"
#include "orchestrator/run/observed_run.h"

namespace tandem::orchestrator {

/// The coupling at steps from H/64 to 8 H, ascending.
[[nodiscard]] std::vector<InterfaceRatios> ratios_over_step(const LoadTrial& load, double step_s);

/// Where explicit_serial stops being stable. The sides answer a step with memory of the last ones,
/// which two derivatives do not show, so the prediction is the safe one and trial runs bracket the
/// limit itself.
struct ExplicitLimit {
  double predicted_s = 0.0;  ///< where explicit_amplification passes 1; 0 = above 1 everywhere
  double stable_s = 0.0;     ///< largest H at which a trial run went through; 0 = none did
  double unstable_s = 0.0;   ///< smallest H at which one diverged; 0 = none did
  bool out_of_time = false;  ///< before the two were near each other
};
[[nodiscard]] ExplicitLimit explicit_limit(const LoadTrial& load,
                                           const std::vector<InterfaceRatios>& ratios,
                                           Prediction prediction,
                                           const std::filesystem::path& folder,
                                           double deadline_s = kNoDeadline);

}  // namespace tandem::orchestrator
