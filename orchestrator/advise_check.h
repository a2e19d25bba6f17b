#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "orchestrator/explicit_limit.h"
#include "orchestrator/observed_run.h"

namespace tandem::orchestrator {

/// What a run with a scheme and a macro step did, and how much of it a run with half the step does
/// otherwise.
struct StepTrial {
  double step_s = 0.0;
  double simulated_s = 0.0;  ///< how long both runs went on, of the run's length
  double wall_s = 0.0;       ///< of both
  std::string status;        ///< of the run with the step
  /// Largest turning of a rigid body or a port per macro step (rad).
  double turn_rad = 0.0;
  /// Peak of the flexible body's elastic energy (J) with the step and with half of it.
  double elastic_peak_J = 0.0, elastic_peak_half_J = 0.0;
  /// Largest difference of the port motions over their travel.
  double port_change = 0.0;

  /// Part of the elastic energy's peak that half the step changes; 0 where there is none.
  [[nodiscard]] double elastic_change() const;
  /// Why the step is too long; empty: it is not.
  [[nodiscard]] std::string objection() const;
};

/// The search for a macro step that stands up to a run.
struct StepCheck {
  std::vector<StepTrial> trials;  ///< in the order they were made
  double step_s = 0.0;            ///< the step that stood up; 0 = none did within the time
  bool whole_run = false;         ///< whether over the run's length
};

struct StepCheckOptions {
  std::string scheme;
  double step_s = 0.0;    ///< first one to try
  double length_s = 0.0;  ///< of the run
  double wall_per_step_s = 0.0;
  double most_s = 0.0;  ///< wall time for all trials
  double shortest_s = 0.0;
  std::filesystem::path folder;
};

/// Runs the scheme with the step and with half of it, over the run's length or as far as the wall
/// time allows, and shortens the step until nothing turns by more than 0.2 rad per step, the run is
/// solved, and the peak of the flexible body's elastic energy, which its own motion sets and not
/// that of the ports, changes by less than a fifth with half the step: what grows does not pass.
/// `load` must switch on energy.csv and bodies.csv at every macro step.
[[nodiscard]] StepCheck check_step(const LoadTrial& load, const StepCheckOptions& options);

/// The next smaller number of the form 1, 2, 5 × 10ⁿ.
[[nodiscard]] double nice_below(double value);

}  // namespace tandem::orchestrator
