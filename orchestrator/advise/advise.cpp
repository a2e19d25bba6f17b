#include "orchestrator/advise/advise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

constexpr double kReach = 100.0;  // recommended steps lie between H/100 and 100 H
constexpr double kFewestStepsOfRun = 20.0;
/// Parts of the wall time after which the search for the explicit limit and the trial runs end.
constexpr double kLimitPart = 0.2;
constexpr double kTrialPart = 0.5;
/// Part of what is left that is kept for the scenario's own settings, at most.
constexpr double kOwnPart = 0.25;

TrialOptions trial_options(const Advice& advice, const AdviseOptions& options, double deadline_s) {
  const double stable_s = advice.limit.stable_s;
  TrialOptions trial{.step_s = advice.step_s,
                     .steps = options.trial_steps,
                     // Half the limit is half the scenario's H at most: as many exchanges as an
                     // iterated scheme's, and all trial runs would be as short.
                     .explicit_serial = stable_s >= advice.step_s,
                     .deadline_s = deadline_s,
                     .folder = options.folder / "trials"};
  if (trial.explicit_serial && stable_s < 2.0 * advice.step_s) {
    trial.step_s = std::min(advice.step_s, nice_below(0.5 * stable_s));
  }
  return trial;
}

/// A candidate at the trial step, where nothing better is known of it.
Contender at_step(const TrialRow& row, double longest_s, double length_s) {
  const double step_s = std::min(row.numbers.step_s, longest_s);
  return {
      .candidate = row.candidate,
      .prospect = {.known = false,
                   .order = static_cast<double>(row.candidate.pair.order),
                   .step_s = divides(step_s, length_s) ? step_s : nice_step_below(step_s, length_s),
                   .wall_per_s = row.numbers.wall_per_step_s / step_s},
      .wall_per_step_s = row.numbers.wall_per_step_s};
}

std::vector<Contender> measured_contenders(const Advice& advice, double length_s) {
  std::vector<Contender> contenders;
  const Trials& trials = advice.trials;
  for (const TrialRow& row : trials.rows) {
    if (!row.numbers.solved) continue;
    double longest_s = std::min(kReach * trials.step_s, length_s / kFewestStepsOfRun);
    if (row.candidate.scheme == "explicit_serial") {
      // Half the limit: errors of the wrench must not only stay but die out.
      longest_s = std::min(longest_s, 0.5 * advice.limit.stable_s);
    }
    Contender contender = at_step(row, longest_s, length_s);
    const Prospect prospect =
        prospect_of(row.numbers, {.wanted_m = advice.accuracy * trials.travel_m,
                                  .reference_error_m = trials.reference_error_m,
                                  .longest_s = longest_s,
                                  .shortest_s = trials.step_s / kReach,
                                  .run_s = length_s});
    if (prospect.known) contender.prospect = prospect;
    contenders.push_back(std::move(contender));
  }
  return contenders;
}

/// Without trial runs: the scenario's own settings, and what is more robust at a higher price.
std::vector<Contender> unmeasured_contenders(const Model& model, const Advice& advice) {
  std::vector<Contender> contenders;
  const auto add = [&](const std::string& scheme, const IntegratorPair& pair) {
    const double wall_per_step_s =
        advice.trials.own_wall_per_step_s * (1.0 + static_cast<double>(contenders.size()));
    contenders.push_back({.candidate = make_candidate(model, scheme, pair),
                          .prospect = {.known = false,
                                       .order = static_cast<double>(pair.order),
                                       .step_s = advice.step_s,
                                       .wall_per_s = wall_per_step_s / advice.step_s},
                          .wall_per_step_s = wall_per_step_s});
  };
  const std::string scheme = to_string(model.coupling.scheme);
  const std::vector<IntegratorPair> pairs = integrator_pairs(model);
  add(scheme, pairs.front());
  if (scheme != "interface_jacobian") add("interface_jacobian", pairs.front());
  if (pairs.size() > 1) add("interface_jacobian", pairs[1]);
  return contenders;
}

std::vector<Contender> contenders_of(const Model& model, const Advice& advice, double length_s) {
  std::vector<Contender> contenders = measured_contenders(advice, length_s);
  if (contenders.empty()) contenders = unmeasured_contenders(model, advice);
  for (Contender& contender : contenders) {
    contender.own = contender.candidate.pair.name == "own" &&
                    contender.candidate.scheme == to_string(model.coupling.scheme);
  }
  return contenders;
}

/// Wall time for the check: what is left without what the scenario's own settings need.
double check_time_s(const Advice& advice, const AdviseOptions& options, double length_s,
                    double left_s) {
  const double own_s = advice.trials.own_wall_per_step_s * length_s / advice.step_s;
  return std::min(options.check_s, left_s - std::min(1.2 * own_s, kOwnPart * left_s));
}

Recommendation recommendation(const Model& model, const Advice& advice, double length_s) {
  Recommendation made;
  if (const StepTrial* trial = advice.checked()) {
    made.settings = trial->settings;
    made.macro_step_s = trial->step_s;
  } else {
    // Nothing was run to its end: what the check would have begun with.
    const auto first = std::min_element(
        advice.contenders.begin(), advice.contenders.end(),
        [](const auto& a, const auto& b) { return a.prospect.wall_per_s < b.prospect.wall_per_s; });
    made.settings = first->candidate.settings;
    made.macro_step_s = first->prospect.step_s;
  }
  made.scheme = to_string(model.coupling.scheme);
  for (const std::string& setting : made.settings) {
    const std::string key = "coupling.scheme=";
    if (setting.starts_with(key)) made.scheme = setting.substr(key.size());
  }
  if (model.coupling.adaptive.active()) made.settings.emplace_back("coupling.adaptive.tolerance=0");
  if (made.macro_step_s != advice.step_s) {
    made.settings = joined(std::move(made.settings), step_settings(model, made.macro_step_s));
  }
  if (!divides(made.macro_step_s, length_s)) {
    const double steps = std::max(1.0, std::round(length_s / made.macro_step_s));
    made.settings.push_back(fmt::format("run.duration_s={}", steps * made.macro_step_s));
  }
  return made;
}

void compare_with_own(const LoadTrial& load, const Model& model, const std::vector<PortInfo>& ports,
                      const AdviseOptions& options, double deadline_s, Advice& advice) {
  const StepTrial* trial = advice.checked();
  if (trial == nullptr || now_s() >= deadline_s) return;
  Recommendation& made = advice.recommended;
  if (made.settings.empty()) {
    made.own = true;
    return;
  }
  advice.own = run_own(load, model, ports, *trial, options.folder / "check" / "own", deadline_s);
  if (!own_is_better(advice.own.standing, standing_of(*trial), advice.accuracy)) return;
  made = {.scheme = to_string(model.coupling.scheme),
          .macro_step_s = advice.step_s,
          .settings = {},
          .own = true};
}

}  // namespace

Advice advise(const LoadTrial& load, const AdviseOptions& options) {
  const double start_s = now_s();
  const double end_s = start_s + options.most_s;
  const Model model = load({}, 0.0, 0.0);
  const double length_s = to_seconds(model.run.duration);
  const std::vector<PortInfo> ports = make_fem(model, {})->info().ports;
  Advice advice{.scenario = model.name,
                .step_s = to_seconds(model.run.macro_step),
                .accuracy = options.accuracy,
                .prediction = model.coupling.prediction,
                .prediction_name = model.scenario.root.section("coupling").text("prediction"),
                .junctions = has_junctions(model)};
  advice.ratios = ratios_over_step(load, advice.step_s);
  advice.at_step = *std::find_if(advice.ratios.begin(), advice.ratios.end(),
                                 [&](const auto& r) { return r.step_s >= advice.step_s; });
  if (!advice.junctions) {
    advice.limit = explicit_limit(load, advice.ratios, advice.prediction, options.folder,
                                  start_s + kLimitPart * options.most_s);
  }
  advice.trials = run_trials(load, model,
                             trial_options(advice, options, start_s + kTrialPart * options.most_s));
  advice.contenders = contenders_of(model, advice, length_s);
  advice.check = check_steps(load, ports, advice.contenders,
                             {.accuracy = options.accuracy,
                              .length_s = length_s,
                              .most_s = check_time_s(advice, options, length_s, end_s - now_s()),
                              .shortest_s = advice.step_s / kReach,
                              .folder = options.folder / "check"});
  advice.recommended = recommendation(model, advice, length_s);
  compare_with_own(load, model, ports, options, end_s, advice);
  explain(advice, length_s);
  return advice;
}

}  // namespace tandem::orchestrator
