#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "orchestrator/advise/explicit_limit.h"
#include "orchestrator/advise/interface_ratios.h"
#include "orchestrator/advise/own_run.h"
#include "orchestrator/advise/step_check.h"
#include "orchestrator/advise/trials.h"

namespace tandem::orchestrator {

struct AdviseOptions {
  double accuracy = 1e-3;          ///< wanted error of port positions relative to their travel
  std::int64_t trial_steps = 100;  ///< length of the trial runs in macro steps of the scenario
  double check_s = 60.0;           ///< wall time for runs over the scenario's length
  double most_s = 180.0;           ///< wall time for everything, the check included
  std::filesystem::path folder;    ///< holds the trial runs and advise.json
};

struct Recommendation {
  std::string scheme;
  double macro_step_s = 0.0;
  Settings settings;  ///< as `tandem run --set` takes them; none: the scenario as it is
  bool own = false;   ///< the scenario's own settings, for they are as good and no dearer
};

struct Advice {
  std::string scenario;
  double step_s = 0.0;  ///< the scenario's H
  double accuracy = 0.0;
  std::vector<InterfaceRatios> ratios;  ///< at several H, ascending
  InterfaceRatios at_step;              ///< the one at the scenario's H
  Prediction prediction = Prediction::Linear;
  std::string prediction_name;
  bool junctions = false;  ///< frames without mass: no explicit scheme takes them
  ExplicitLimit limit;
  Trials trials;
  std::vector<Contender> contenders;  ///< as the trials promise them
  StepCheck check;
  OwnRun own;
  Recommendation recommended;
  std::vector<std::string> reasons;
  std::vector<std::string> undecided;  ///< what the runs could not tell

  /// The trial by which the recommendation goes; null: there is none.
  [[nodiscard]] const StepTrial* checked() const {
    return check.best ? &check.trials[*check.best] : nullptr;
  }
};

/// Measures the coupling at every port from the two interface derivatives, predicts where the
/// explicit scheme stays stable, tries schemes and integrators for a while in process, and
/// recommends the cheapest ones with a macro step and solver settings that stand up to a run over
/// the scenario's length, beside the scenario's own settings. What the wall time does not suffice
/// for is left out and said.
[[nodiscard]] Advice advise(const LoadTrial& load, const AdviseOptions& options);

/// Why the advice is what it is, and what it leaves open: `reasons` and `undecided`.
void explain(Advice& advice, double length_s);

[[nodiscard]] nlohmann::ordered_json advice_json(const Advice& advice);
/// `command`: `tandem run` with the scenario and what the user has set.
[[nodiscard]] std::string advice_text(const Advice& advice, const std::string& command);

}  // namespace tandem::orchestrator
