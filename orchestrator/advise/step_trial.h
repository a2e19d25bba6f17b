#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "orchestrator/advise/choice.h"
#include "orchestrator/advise/load_trial.h"
#include "orchestrator/run/observed_run.h"

namespace tandem::orchestrator {

/// Part of the elastic energy's peak that half the step may change.
inline constexpr double kMostElasticChange = 0.2;
/// Part of the largest wrench at the ports that half the step may change.
inline constexpr double kMostWrenchChange = 0.2;

/// A run in process and what its books say.
struct JudgedRun {
  std::string status;
  std::string message;
  double simulated_s = 0.0;
  double wall_s = 0.0;
  double turn_rad = 0.0;  ///< largest of a port or body in a macro step
  nlohmann::ordered_json verdict;
  History history;
  std::filesystem::path folder;

  [[nodiscard]] double wall_per_s() const { return simulated_s > 0.0 ? wall_s / simulated_s : 0.0; }
  /// Peak of the flexible body's elastic energy up to then (J); 0 without an energy.csv.
  [[nodiscard]] double elastic_peak_J(double until_s) const;
};
/// `load` must switch on energy.csv and bodies.csv at every macro step.
[[nodiscard]] JudgedRun judged_run(const Model& model, const std::filesystem::path& folder,
                                   const std::string& title, double deadline_s);

/// What a run with a step did, and how much of it a run with half the step does otherwise.
struct StepTrial {
  std::string name;   ///< of the candidate
  Settings settings;  ///< of it, without the step
  double step_s = 0.0;
  double simulated_s = 0.0;  ///< how long both runs went on, of the run's length
  bool whole = false;        ///< whether that is all of it
  double wall_s = 0.0;       ///< of both
  double wall_per_s = 0.0;   ///< wall time per simulated second with the step
  std::string status;        ///< of the run with the step
  double turn_rad = 0.0;
  double elastic_peak_J = 0.0, elastic_peak_half_J = 0.0;
  double wrench_peak_N = 0.0, wrench_peak_half_N = 0.0;  ///< of ‖Λ‖
  /// Largest difference of the port motions, over their travel; below 0: there is no other run.
  double port_change = -1.0;
  /// Of the port motion over its travel, from that difference and the order; below 0: not known.
  double error = -1.0;
  nlohmann::ordered_json verdict;
  std::vector<Objection> objections;
  std::vector<Objection> told;  ///< what shorter steps do not cure
  History half;                 ///< of the run with half the step

  /// Part of the elastic energy's peak that half the step changes; 0 where there is none.
  [[nodiscard]] double elastic_change() const;
  /// The same of the largest wrench.
  [[nodiscard]] double wrench_change() const;
};

/// The largest ‖Λ‖ up to then (N).
[[nodiscard]] double largest_wrench_N(const History& history, const std::vector<PortInfo>& ports,
                                      double until_s);

struct StepQuestion {
  std::string name;
  Settings settings;
  double order = 1.0;  ///< of the candidate's error
  double step_s = 0.0;
  double length_s = 0.0;
  bool whole = false;             ///< the scenario as it is, not only its beginning
  double accuracy = 1e-3;         ///< wanted error over the travel
  bool half_in_any_case = false;  ///< also where the run with the step is objected to
  std::filesystem::path folder;
  double deadline_s = kNoDeadline;
};

/// Runs the step, and half of it unless the first run was objected to. What speaks against it: that
/// it is not solved, a cause of the verdict, the peak of the flexible body's elastic energy, which
/// its own motion sets and not that of the ports, where half the step changes it by more than a
/// fifth, the largest wrench likewise, and an error of the ports above the wanted one. A half that
/// is broken off at the deadline is compared as far as it goes; a run with the step that is broken
/// off has the status kOutOfTime.
[[nodiscard]] StepTrial try_step(const LoadTrial& load, const std::vector<PortInfo>& ports,
                                 const StepQuestion& question);

/// The objections to a run by itself.
[[nodiscard]] std::vector<Objection> objections_to(const JudgedRun& run, double order);

}  // namespace tandem::orchestrator
