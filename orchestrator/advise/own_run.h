#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "orchestrator/advise/step_trial.h"

namespace tandem::orchestrator {

/// The scenario's own settings in a run over the time that the recommended ones were checked for.
struct OwnRun {
  bool made = false;
  std::string status;
  double simulated_s = 0.0;  ///< less than that where the wall time was spent
  double wall_per_s = 0.0;
  double error = -1.0;  ///< of the port motion over its travel; below 0: not known
  nlohmann::ordered_json verdict;
  Standing standing;
};

/// `recommended`: the trial whose run with half the step the error is measured against.
[[nodiscard]] OwnRun run_own(const LoadTrial& load, const Model& model,
                             const std::vector<PortInfo>& ports, const StepTrial& recommended,
                             const std::filesystem::path& folder, double deadline_s);

/// The same of the recommended trial.
[[nodiscard]] Standing standing_of(const StepTrial& trial);

}  // namespace tandem::orchestrator
