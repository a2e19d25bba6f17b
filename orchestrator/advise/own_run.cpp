#include "orchestrator/advise/own_run.h"

#include <algorithm>
#include <cmath>

#include "orchestrator/advise/candidates.h"

namespace tandem::orchestrator {

OwnRun run_own(const LoadTrial& load, const Model& model, const std::vector<PortInfo>& ports,
               const StepTrial& recommended, const std::filesystem::path& folder,
               double deadline_s) {
  const double step_s = to_seconds(model.run.macro_step);
  const double length_s =
      step_s * std::max(1.0, std::floor(recommended.simulated_s / step_s * (1.0 + 1e-9)));
  const JudgedRun run =
      judged_run(load(own_settings(model), 0.0, recommended.whole ? 0.0 : length_s), folder,
                 "check: the scenario's own settings", deadline_s);
  OwnRun own{.made = true,
             .status = run.status,
             .simulated_s = run.simulated_s,
             .wall_per_s = run.wall_per_s(),
             .verdict = run.verdict};
  std::vector<Objection> objections = objections_to(run, 1.0);
  if (recommended.error >= 0.0) {
    const double travel_m = largest_travel_m(recommended.half, ports);
    const double distance =
        travel_m > 0.0 ? motion_distance(run.history, recommended.half, ports).motion_m / travel_m
                       : 0.0;
    // The run that it is measured against has an error, too.
    own.error = distance + (recommended.error - recommended.port_change);
    const double peak_J = run.elastic_peak_J(recommended.simulated_s);
    StepTrial peaks;
    peaks.elastic_peak_J = peak_J;
    peaks.elastic_peak_half_J = recommended.elastic_peak_half_J;
    peaks.wrench_peak_N = largest_wrench_N(run.history, ports, recommended.simulated_s);
    peaks.wrench_peak_half_N = recommended.wrench_peak_half_N;
    if (peaks.elastic_change() > kMostElasticChange) objections.push_back({.name = "elastic_peak"});
    if (peaks.wrench_change() > kMostWrenchChange) objections.push_back({.name = "wrench_peak"});
  }
  own.standing = {.whole = run.status == "done" && own.error >= 0.0,
                  .wall_per_s = own.wall_per_s,
                  .error = own.error,
                  .severity = severity(objections)};
  return own;
}

Standing standing_of(const StepTrial& trial) {
  std::vector<Objection> all = trial.objections;
  all.insert(all.end(), trial.told.begin(), trial.told.end());
  return {.whole = trial.status == "done",
          .wall_per_s = trial.wall_per_s,
          .error = std::max(0.0, trial.error),
          .severity = severity(all)};
}

}  // namespace tandem::orchestrator
