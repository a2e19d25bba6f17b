#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "orchestrator/advise/candidates.h"
#include "orchestrator/advise/solver_trials.h"
#include "orchestrator/advise/step_trial.h"

namespace tandem::orchestrator {

/// What the check goes through: candidates with what their trial runs promise.
struct Contender {
  Candidate candidate;
  Prospect prospect;
  double wall_per_step_s = 0.0;
  bool own = false;  ///< the scenario's scheme and integrators
};

/// The search for a candidate and a macro step that stand up to a run.
struct StepCheck {
  std::vector<StepTrial> trials;           ///< in the order they were made
  std::vector<SolverTrial> solver_trials;  ///< of all candidates that were checked
  std::optional<std::size_t> best;  ///< the trial to go by: without objections, or the least bad
  bool stands = false;              ///< whether nothing speaks against it
  bool out_of_time = false;
};

struct StepCheckOptions {
  double accuracy = 1e-3;  ///< wanted error over the travel
  double length_s = 0.0;   ///< of the run
  double most_s = 0.0;     ///< wall time for all of it
  double shortest_s = 0.0;
  std::filesystem::path folder;
};

/// Checks the cheapest contender at its step (try_step), with the solver settings that save wall
/// time with it, over the run's length or as far as the wall time allows. What speaks against it
/// gives it a shorter step and a higher price; then the cheapest one is checked again, which may be
/// another. An angle per step bounds the steps of all. What half the step does not change is told
/// and not acted upon.
[[nodiscard]] StepCheck check_steps(const LoadTrial& load, const std::vector<PortInfo>& ports,
                                    std::vector<Contender> contenders,
                                    const StepCheckOptions& options);

}  // namespace tandem::orchestrator
