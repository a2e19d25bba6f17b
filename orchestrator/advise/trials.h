#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "orchestrator/advise/candidates.h"
#include "orchestrator/advise/choice.h"

namespace tandem::orchestrator {

/// A candidate in the trial runs.
struct TrialRow {
  Candidate candidate;
  std::string status;
  double exchanges_per_step = 0.0;
  TrialNumbers numbers;
};

/// All candidates at one step and half of it, from the scenario's start, against a fine monolithic
/// run. The reference has integrators of second order where the sides allow them: the solution is
/// the same, and its own error far below that of all candidates.
struct Trials {
  double step_s = 0.0;
  double length_s = 0.0;
  double own_wall_per_step_s = 0.0;  ///< of the scenario's own settings
  double reference_step_s = 0.0;
  std::string reference_pair;
  double reference_error_m = 0.0;  ///< distance from the reference with twice its step
  double travel_m = 0.0;           ///< of the ports, see largest_travel_m
  std::vector<TrialRow> rows;
  std::vector<std::string> undecided;  ///< what the runs could not tell, and who has no row
};

struct TrialOptions {
  double step_s = 0.0;
  std::int64_t steps = 100;  ///< fewer where the wall time does not suffice
  bool explicit_serial = true;
  double deadline_s = 0.0;  ///< of now_s()
  std::filesystem::path folder;
};

/// Runs the candidates: the scenario's scheme, interface_jacobian, explicit_serial and implicit
/// with the scenario's integrators, interface_jacobian with the other pairs, and the other schemes
/// with them where a macro step has cost less than one of interface_jacobian.
[[nodiscard]] Trials run_trials(const LoadTrial& load, const Model& model,
                                const TrialOptions& options);

}  // namespace tandem::orchestrator
