#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "orchestrator/advise_check.h"
#include "orchestrator/explicit_limit.h"
#include "orchestrator/interface_ratios.h"
#include "orchestrator/work_precision.h"

namespace tandem::orchestrator {

struct AdviseOptions {
  double accuracy = 1e-3;          ///< wanted error of port positions relative to their travel
  std::int64_t trial_steps = 100;  ///< length of the trial runs in macro steps of the scenario
  double check_s = 60.0;           ///< wall time for runs over the scenario's length
  double most_s = 180.0;           ///< wall time for everything, the check included
  std::filesystem::path folder;    ///< holds the trial runs and advise.json
};

/// One scheme in the trial runs.
struct SchemeAdvice {
  std::string scheme;
  bool solved = false;  ///< at the trial step
  std::string status;
  double error_m = 0.0;  ///< at the trial step, against a fine monolithic run
  double order = 0.0;    ///< from the trial step and half of it
  double exchanges_per_step = 0.0;
  double step_for_accuracy_s = 0.0;   ///< H at which the wanted accuracy is expected; 0 = unknown
  double exchanges_per_second = 0.0;  ///< of simulated time, at that H
};

struct Advice {
  std::string scenario;
  double step_s = 0.0;  ///< the scenario's H
  /// H, or less where explicit_serial would not be stable: all schemes are tried at one step.
  double trial_step_s = 0.0;
  double travel_m = 0.0;
  double accuracy = 0.0;
  std::vector<InterfaceRatios> ratios;  ///< at several H, ascending
  InterfaceRatios at_step;              ///< the one at the scenario's H
  Prediction prediction = Prediction::Linear;
  std::string prediction_name;
  ExplicitLimit limit;
  std::vector<SchemeAdvice> schemes;
  std::string scheme;         ///< recommended
  double macro_step_s = 0.0;  ///< recommended
  std::vector<std::string> reasons;
  StepCheck check;                     ///< of the recommended step, by runs with it
  std::vector<std::string> undecided;  ///< what the runs could not tell
};

/// Measures the coupling at every port from the two interface derivatives, predicts where the
/// explicit scheme stays stable, tries the schemes for a while in process, and recommends a scheme
/// and a macro step, which it shortens until it stands up to a run over the scenario's length. What
/// the wall time does not suffice for is left out and said.
[[nodiscard]] Advice advise(const LoadTrial& load, const AdviseOptions& options);

[[nodiscard]] nlohmann::ordered_json advice_json(const Advice& advice);
[[nodiscard]] std::string advice_text(const Advice& advice);

}  // namespace tandem::orchestrator
