#include <fmt/format.h>

#include <algorithm>

#include "orchestrator/advise/advise.h"

namespace tandem::orchestrator {
namespace {

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

void explain_coupling(Advice& advice) {
  if (advice.junctions) {
    advice.reasons.emplace_back(
        "mbs.junctions have no mass: schemes that do not iterate are out of the question, and the "
        "ratios of masses at their ports are those of what stands in for it");
    return;
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
  if (advice.limit.out_of_time) {
    advice.undecided.push_back(
        "where explicit_serial stops being stable, more closely than above: the wall time for it "
        "is spent. Raise --most-s.");
  }
  if (advice.limit.stable_s < advice.step_s) {
    advice.reasons.push_back(
        "explicit_serial, kept below half its limit, needs more than two macro steps in the "
        "scenario's H, no fewer exchanges than interface_jacobian: it was left out of the trial "
        "runs. Where the error asks for steps that short, compare --steps shows what it brings");
  }
}

void explain_trials(Advice& advice) {
  const Trials& trials = advice.trials;
  for (const std::string& open : trials.undecided) advice.undecided.push_back(open);
  const auto known = [](const Contender& contender) { return contender.prospect.known; };
  if (!trials.rows.empty() &&
      std::none_of(advice.contenders.begin(), advice.contenders.end(), known)) {
    advice.undecided.push_back(fmt::format(
        "which step has an error of {:g} of the travel, from the trial runs: they were too short "
        "or too accurate to tell. Raise --trial-steps or --most-s.",
        advice.accuracy));
  }
}

void explain_trial(const StepTrial& trial, Advice& advice) {
  for (const Objection& objection : trial.objections) {
    const std::string remedy = objection.remedy.empty() ? "" : " (" + objection.remedy + ")";
    advice.reasons.push_back(fmt::format("{} with H = {:g} s, a run over {:g} s: {}{}", trial.name,
                                         trial.step_s, trial.simulated_s, objection.text, remedy));
  }
}

std::string told_text(const Objection& told) {
  return fmt::format("{}{}", told.text, told.remedy.empty() ? "" : ": " + told.remedy);
}

/// What the trial that the recommendation goes by leaves to say.
void explain_recommended(const StepTrial& trial, double length_s, Advice& advice) {
  if (advice.check.stands) {
    advice.reasons.push_back(fmt::format(
        "{} with H = {:g} s: a run over {:g} s is solved; nothing turns by more than {:.2g} rad "
        "per step, and half the step changes the port motions by {:.2g} of their travel, the "
        "peak of the flexible body's elastic energy by {:.2g} of it and the largest wrench by "
        "{:.2g}",
        trial.name, trial.step_s, trial.simulated_s, trial.turn_rad,
        std::max(0.0, trial.port_change), trial.elastic_change(), trial.wrench_change()));
  }
  for (const Objection& told : trial.told) {
    advice.undecided.push_back(
        fmt::format("how to cure this by steps or integrators: {}", told_text(told)));
  }
  if (trial.simulated_s < length_s * (1.0 - 1e-9) - 0.5 * trial.step_s) {
    advice.undecided.push_back(
        fmt::format("what happens after {:g} s of the run's {:g} s: the wall time does not reach "
                    "further. Raise --check-s and --most-s.",
                    trial.simulated_s, length_s));
  }
  if (trial.port_change == 0.0) {
    advice.undecided.push_back(
        "how accurate the ports are: half the step does not change their motion, which is "
        "prescribed");
  }
  if (trial.elastic_peak_half_J == 0.0) {
    advice.undecided.push_back(
        "whether the step resolves the flexible body's own motion: it has no elastic energy here");
  }
}

void explain_check(double length_s, Advice& advice) {
  const StepCheck& check = advice.check;
  for (const StepTrial& trial : check.trials) explain_trial(trial, advice);
  if (!check.stands) {
    advice.undecided.push_back(fmt::format(
        "what stands up to a run over {:g} s: nothing did {}. {}Raise --check-s and --most-s.",
        length_s, check.out_of_time ? "within the wall time" : "down to a hundredth of H",
        check.best ? "Recommended is what was run with the least to object to. " : ""));
  }
  if (const StepTrial* trial = advice.checked()) explain_recommended(*trial, length_s, advice);
}

void explain_own(Advice& advice) {
  if (advice.recommended.own) {
    advice.reasons.emplace_back(
        "the scenario's own settings do what is asked for at no more wall time: nothing to change");
    return;
  }
  if (!advice.own.made) {
    advice.undecided.emplace_back(
        "what the scenario's own settings cost beside it: the wall time for that is spent. Raise "
        "--most-s.");
    return;
  }
  if (advice.own.status == kOutOfTime) {
    advice.undecided.push_back(
        fmt::format("what the scenario's own settings do after {:g} s: the wall time is spent. "
                    "Raise --most-s.",
                    advice.own.simulated_s));
  }
}

}  // namespace

void explain(Advice& advice, double length_s) {
  explain_coupling(advice);
  explain_trials(advice);
  explain_check(length_s, advice);
  explain_own(advice);
}

}  // namespace tandem::orchestrator
