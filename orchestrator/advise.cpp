#include "orchestrator/advise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

constexpr double kReach = 100.0;  // recommended steps lie between H/100 and 100 H
/// Parts of the wall time after which the search for the explicit limit and the trial runs end.
constexpr double kLimitPart = 0.25;
constexpr double kTrialPart = 0.65;

SchemeAdvice judge(const PrecisionRow& coarse, const PrecisionRow& fine, const WorkPrecision& trial,
                   const Advice& advice) {
  SchemeAdvice scheme{.scheme = coarse.scheme,
                      .solved = coarse.exit_code == 0,
                      .status = coarse.status,
                      .error_m = coarse.error.motion_m,
                      .exchanges_per_step = coarse.iterations_mean};
  if (!scheme.solved || fine.exit_code != 0 || !(coarse.error.motion_m > trial.reference_error_m)) {
    return scheme;
  }
  // An error within that of the reference says nothing about the order.
  scheme.order = std::clamp(std::log2(coarse.error.motion_m / fine.error.motion_m), 0.5, 3.0);
  const double wanted_m = advice.accuracy * advice.travel_m;
  scheme.step_for_accuracy_s =
      coarse.step_s * std::pow(wanted_m / coarse.error.motion_m, 1.0 / scheme.order);
  if (scheme.scheme == "explicit_serial") {
    // Half the limit: errors of the wrench must not only stay but die out.
    scheme.step_for_accuracy_s = std::min(scheme.step_for_accuracy_s, advice.limit.stable_s / 2);
  }
  // What two steps say about a third one does not reach further than this.
  scheme.step_for_accuracy_s =
      std::clamp(scheme.step_for_accuracy_s, coarse.step_s / kReach, coarse.step_s * kReach);
  scheme.step_for_accuracy_s = nice_below(scheme.step_for_accuracy_s);
  scheme.exchanges_per_second = scheme.exchanges_per_step / scheme.step_for_accuracy_s;
  return scheme;
}

std::string limit_reason(const Advice& advice) {
  const ExplicitLimit& limit = advice.limit;
  const std::string predicted =
      limit.predicted_s > 0.0
          ? fmt::format("the derivatives promise stability up to H = {:.3g} s", limit.predicted_s)
          : "the derivatives promise stability at no H: inertia couples the sides, and its ratio "
            "does not fall with H";
  if (limit.stable_s == 0.0 && limit.unstable_s == 0.0) {
    return fmt::format("explicit_serial, prediction {}: {}; not tried", advice.prediction_name,
                       predicted);
  }
  const std::string stable = limit.stable_s > 0.0
                                 ? fmt::format("stable at {:.3g} s", limit.stable_s)
                                 : std::string("stable at no step that was tried");
  const std::string unstable = limit.unstable_s > 0.0
                                   ? fmt::format("diverged at {:.3g} s", limit.unstable_s)
                                   : std::string("did not diverge at any step that was tried");
  return fmt::format("explicit_serial, prediction {}: {}; in trial runs it was {} and {}",
                     advice.prediction_name, predicted, stable, unstable);
}

void recommend(Advice& advice) {
  const SchemeAdvice* best = nullptr;
  for (const SchemeAdvice& scheme : advice.schemes) {
    if (scheme.step_for_accuracy_s <= 0.0) continue;
    if (best == nullptr || scheme.exchanges_per_second < best->exchanges_per_second) best = &scheme;
  }
  const double kappa = advice.at_step.coupling_ratio();
  advice.reasons.push_back(fmt::format(
      "at H = {} s one evaluation of both sides multiplies an error of the wrench by {:.3g} (the "
      "coupling ratio): {}",
      advice.step_s, kappa,
      kappa < 0.1   ? "the flexible side is light against what carries it"
      : kappa < 1.0 ? "both sides feel each other"
                    : "the flexible side is heavier or stiffer than what carries it"));
  advice.reasons.push_back(limit_reason(advice));
  if (best == nullptr) {
    advice.scheme = "interface_jacobian";
    advice.macro_step_s = advice.step_s;
    advice.reasons.push_back(
        "no trial run told an error to choose a step by: interface_jacobian at the scenario's H is "
        "what the check begins with");
    advice.undecided.push_back(fmt::format(
        "which step has an error of {:g} of the travel: {}", advice.accuracy,
        advice.schemes.empty() ? "there were no trial runs"
                               : "the trial runs were too short or too accurate to tell. Raise "
                                 "--trial-steps or --most-s."));
    return;
  }
  advice.scheme = best->scheme;
  advice.macro_step_s = best->step_for_accuracy_s;
  advice.reasons.push_back(fmt::format(
      "of the schemes that were solved in the trial runs, {} needs the fewest exchanges for an "
      "error of {:g} of the travel: {:.0f} per simulated second",
      best->scheme, advice.accuracy, best->exchanges_per_second));
  if (best->step_for_accuracy_s < 1.01 * advice.step_s / kReach) {
    advice.reasons.push_back(
        "that accuracy is further than the trial runs can see: compare --steps shows what smaller "
        "steps bring");
  }
}

/// Wall time of a macro step of the recommended scheme in the trial runs, the longest one.
double wall_per_step_s(const WorkPrecision& trial, const std::string& scheme) {
  double longest = 1e-6;
  for (const PrecisionRow& row : trial.rows) {
    if (row.scheme != scheme || row.macro_steps == 0) continue;
    longest = std::max(longest, row.wall_s / static_cast<double>(row.macro_steps));
  }
  return longest;
}

void explain_check(double length_s, double allowed_s, Advice& advice) {
  const StepCheck& check = advice.check;
  for (const StepTrial& trial : check.trials) {
    if (trial.objection().empty()) continue;
    advice.reasons.push_back(fmt::format("H = {:g} s is too long: in a run over {:g} s {}",
                                         trial.step_s, trial.simulated_s, trial.objection()));
  }
  if (check.step_s == 0.0) {
    advice.undecided.push_back(
        fmt::format("whether this step stands up to a run over {:g} s: no step did within {:.3g} s "
                    "of wall time. "
                    "Raise --check-s and --most-s.",
                    length_s, allowed_s));
    return;
  }
  const StepTrial& good = check.trials.back();
  advice.macro_step_s = good.step_s;
  advice.reasons.push_back(fmt::format(
      "a run with it over {:g} s is solved; nothing turns by more than {:.2g} rad per step, and "
      "half the step changes the port motions by {:.2g} of their travel and the peak of the "
      "flexible body's elastic energy by {:.2g} of it",
      good.simulated_s, good.turn_rad, good.port_change, good.elastic_change()));
  if (!check.whole_run) {
    advice.undecided.push_back(
        fmt::format("what happens after {:g} s of the run's {:g} s: {:.3g} s of wall time do not "
                    "reach further. "
                    "Raise --check-s and --most-s.",
                    good.simulated_s, length_s, allowed_s));
  }
  if (good.elastic_peak_J == 0.0) {
    advice.undecided.push_back(
        "whether the step resolves the flexible body's own motion: it has no elastic energy here");
  }
}

/// Shortens the recommended step until a run stands up to it.
void check_recommendation(const LoadTrial& load, const AdviseOptions& options, double length_s,
                          double most_s, const WorkPrecision& trial, Advice& advice) {
  advice.check = check_step(load, {.scheme = advice.scheme,
                                   .step_s = advice.macro_step_s,
                                   .length_s = length_s,
                                   .wall_per_step_s = wall_per_step_s(trial, advice.scheme),
                                   .most_s = most_s,
                                   .shortest_s = advice.step_s / kReach,
                                   .folder = options.folder / "check"});
  explain_check(length_s, most_s, advice);
}

/// Trial runs of all schemes that are candidates, over the time that --trial-steps asks for.
WorkPrecision try_schemes(const LoadTrial& load, const AdviseOptions& options,
                          const scenario::RunParams& run, double deadline_s, Advice& advice) {
  advice.trial_step_s = advice.step_s;
  std::vector<std::string> schemes = {"explicit_serial", "implicit", "interface_jacobian"};
  const double stable_s = advice.limit.stable_s;
  if (stable_s < advice.step_s) {
    // Half the limit is half the scenario's H at most: as many exchanges as an iterated scheme's,
    // and all trial runs would be as short, their reference sixteen times shorter.
    schemes.erase(schemes.begin());
    advice.reasons.push_back(
        "explicit_serial, kept below half its limit, needs more than two macro steps in the "
        "scenario's H, no fewer exchanges than interface_jacobian: it was left out of the trial "
        "runs. Where the error asks for steps that short, compare --steps shows what it brings");
  } else if (stable_s < 2.0 * advice.step_s) {
    advice.trial_step_s = std::min(advice.step_s, nice_below(0.5 * stable_s));
  }
  const double wanted_s =
      std::min(to_seconds(run.duration), static_cast<double>(options.trial_steps) * advice.step_s);
  const double duration_s =
      advice.trial_step_s * std::max(1.0, std::round(wanted_s / advice.trial_step_s));
  try {
    return work_precision([&](const std::string& scheme, double step_s,
                              double /*tolerance*/) { return load(scheme, step_s, duration_s); },
                          {.schemes = schemes,
                           .steps_s = {advice.trial_step_s, 0.5 * advice.trial_step_s},
                           .mode = Mode::Inproc,
                           .folder = options.folder,
                           .deadline_s = deadline_s});
  } catch (const Error& error) {
    // Without its reference a trial has no error to judge by; the check by runs goes on.
    if (error.kind() != ErrorKind::NotSolved) throw;
    advice.undecided.push_back(
        fmt::format("what the schemes' errors are: {} Raise --most-s, or shorten "
                    "the trials by --trial-steps.",
                    error.what()));
    return {};
  }
}

}  // namespace

Advice advise(const LoadTrial& load, const AdviseOptions& options) {
  const double start_s = now_s();
  const Model model = load("", 0.0, 0.0);
  Advice advice{.scenario = model.name,
                .step_s = to_seconds(model.run.macro_step),
                .accuracy = options.accuracy,
                .prediction = model.coupling.prediction,
                .prediction_name = model.scenario.root.section("coupling").text("prediction")};
  advice.ratios = ratios_over_step(load, advice.step_s);
  advice.at_step = *std::find_if(advice.ratios.begin(), advice.ratios.end(),
                                 [&](const auto& r) { return r.step_s >= advice.step_s; });
  advice.limit = explicit_limit(load, advice.ratios, advice.prediction, options.folder,
                                start_s + kLimitPart * options.most_s);
  if (advice.limit.out_of_time) {
    advice.undecided.push_back(
        "where explicit_serial stops being stable, more closely than below: the wall time for it "
        "is spent. Raise --most-s.");
  }
  const WorkPrecision trial =
      try_schemes(load, options, model.run, start_s + kTrialPart * options.most_s, advice);
  advice.travel_m = trial.travel_m;
  // Rows come in pairs, the trial step and half of it; the first pair is the monolithic run's.
  for (std::size_t i = 2; i + 1 < trial.rows.size(); i += 2) {
    advice.schemes.push_back(judge(trial.rows[i], trial.rows[i + 1], trial, advice));
  }
  recommend(advice);
  const double left_s = std::max(0.0, start_s + options.most_s - now_s());
  check_recommendation(load, options, to_seconds(model.run.duration),
                       std::min(options.check_s, left_s), trial, advice);
  return advice;
}

}  // namespace tandem::orchestrator
