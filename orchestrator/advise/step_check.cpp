#include "orchestrator/advise/step_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

constexpr int kMostTrials = 30;
/// What a step takes more than was foreseen, once a trial has not come to its end.
constexpr double kSlower = 4.0;
/// Fewer macro steps than this say nothing of a run.
constexpr double kFewestCheckedSteps = 20.0;
/// Macro steps of a trial in those of its run with the step: that one, and half the step.
constexpr double kRuns = 3.0;
/// Part of the wall time that is left which one trial may take, and the choice of a solver.
constexpr double kHalfOfRest = 0.5;
constexpr double kSolverPart = 0.15;

class Check {
 public:
  Check(const LoadTrial& load, const std::vector<PortInfo>& ports,
        std::vector<Contender> contenders, const StepCheckOptions& options)
      : load_(load),
        ports_(ports),
        contenders_(std::move(contenders)),
        options_(options),
        end_s_(now_s() + options.most_s),
        solver_settings_(contenders_.size()),
        last_trial_(contenders_.size()) {}

  StepCheck run() {
    for (int n = 1; n <= kMostTrials; ++n) {
      const std::optional<std::size_t> next = next_contender();
      if (!next) break;
      if (!try_next(*next, n)) {
        check_.out_of_time = true;
        break;
      }
      if (check_.stands) break;
    }
    if (!check_.best) check_.best = least_bad();
    return std::move(check_);
  }

 private:
  std::optional<std::size_t> next_contender() {
    std::vector<Prospect> prospects;
    std::optional<std::size_t> own;
    for (Contender& contender : contenders_) {
      if (contender.prospect.step_s < options_.shortest_s * (1.0 - 1e-9)) {
        contender.prospect.step_s = 0.0;
      }
      if (contender.own) own = prospects.size();
      prospects.push_back(contender.prospect);
    }
    return cheapest(prospects, own);
  }

  /// False where the wall time does not suffice.
  bool try_next(std::size_t i, int number) {
    Contender& contender = contenders_[i];
    const std::filesystem::path folder = options_.folder / std::to_string(number);
    choose_solver(i, folder);
    const double allowed_s = kHalfOfRest * std::max(0.0, end_s_ - now_s());
    const double step_s = contender.prospect.step_s;
    const double asked = std::max(1.0, std::round(options_.length_s / step_s));
    const double affordable =
        std::floor(allowed_s / (kRuns * std::max(1e-9, contender.wall_per_step_s)));
    const double steps = std::min(asked, affordable);
    if (steps < std::min(kFewestCheckedSteps, asked)) return false;
    StepTrial trial =
        try_or_refuse({.name = contender.candidate.name(),
                       .settings = joined(contender.candidate.settings, *solver_settings_[i]),
                       .order = contender.prospect.order,
                       .step_s = step_s,
                       .length_s = steps * step_s,
                       .whole = steps == asked && divides(step_s, options_.length_s),
                       .accuracy = options_.accuracy,
                       .half_in_any_case = last_trial_[i].has_value(),
                       .folder = folder,
                       .deadline_s = now_s() + allowed_s});
    if (trial.status == kOutOfTime) {
      contender.wall_per_step_s *= kSlower;
      contender.prospect.wall_per_s *= kSlower;
      return true;
    }
    if (trial.wall_per_s > 0.0) {
      contender.wall_per_step_s = trial.wall_per_s * step_s;
      contender.prospect.wall_per_s = trial.wall_per_s;
    }
    book(i, std::move(trial));
    return true;
  }

  /// A step that the scenario refuses, e.g. since a scheduled change would come too late, is none.
  [[nodiscard]] StepTrial try_or_refuse(const StepQuestion& question) const {
    try {
      return try_step(load_, ports_, question);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::Usage) throw;
      StepTrial trial;
      trial.name = question.name;
      trial.settings = question.settings;
      trial.step_s = question.step_s;
      trial.status = "refused";
      trial.objections = {{.name = "not_solved", .text = error.what(), .remedy = ""}};
      return trial;
    }
  }

  void choose_solver(std::size_t i, const std::filesystem::path& folder) {
    if (solver_settings_[i]) return;
    const Contender& contender = contenders_[i];
    const std::vector<SolverTrial> trials =
        try_solvers(load_, ports_,
                    {.name = contender.candidate.name(),
                     .settings = contender.candidate.settings,
                     .step_s = contender.prospect.step_s,
                     .length_s = options_.length_s,
                     .wall_per_step_s = contender.wall_per_step_s,
                     .accuracy = options_.accuracy,
                     .folder = folder / "solver",
                     .deadline_s = now_s() + kSolverPart * std::max(0.0, end_s_ - now_s())});
    solver_settings_[i] = taken_settings(trials);
    check_.solver_trials.insert(check_.solver_trials.end(), trials.begin(), trials.end());
  }

  void book(std::size_t i, StepTrial trial) {
    tell_what_stays(i, trial);
    if (trial.objections.empty()) {
      check_.best = check_.trials.size();
      check_.stands = true;
    } else {
      shorten(i, trial);
    }
    last_trial_[i] = check_.trials.size();
    check_.trials.push_back(std::move(trial));
  }

  /// What stands as it did with the candidate's longer step.
  void tell_what_stays(std::size_t i, StepTrial& trial) const {
    if (!last_trial_[i]) return;
    const StepTrial& before = check_.trials[*last_trial_[i]];
    std::vector<Objection> all = before.objections;
    all.insert(all.end(), before.told.begin(), before.told.end());
    const auto stays = std::stable_partition(
        trial.objections.begin(), trial.objections.end(), [&](const Objection& objection) {
          return !stubborn(objection, trial.step_s, all, before.step_s);
        });
    trial.told.insert(trial.told.end(), stays, trial.objections.end());
    trial.objections.erase(stays, trial.objections.end());
  }

  void shorten(std::size_t i, const StepTrial& trial) {
    const auto set = [&](Contender& contender, double step_s) {
      contender.prospect.wall_per_s *= contender.prospect.step_s / step_s;
      contender.prospect.step_s = step_s;
    };
    set(contenders_[i], shortened(trial.step_s, trial.objections, options_.length_s));
    for (const Objection& objection : trial.objections) {
      if (objection.name != "turn_per_step") continue;
      const double bound_s = trial.step_s * objection.limit / objection.value;
      for (Contender& contender : contenders_) {
        if (contender.prospect.step_s <= bound_s * (1.0 + 1e-9)) continue;
        set(contender, nice_step_below(bound_s, options_.length_s));
      }
    }
  }

  /// The trial that is solved, has the least to object to, and then the least error.
  [[nodiscard]] std::optional<std::size_t> least_bad() const {
    std::optional<std::size_t> best;
    const auto rank = [&](std::size_t i) {
      const StepTrial& trial = check_.trials[i];
      return std::pair(severity(trial.objections), trial.error < 0.0 ? 1e300 : trial.error);
    };
    for (std::size_t i = 0; i < check_.trials.size(); ++i) {
      if (severity(check_.trials[i].objections) == 3) continue;
      if (!best || rank(i) < rank(*best)) best = i;
    }
    return best;
  }

  const LoadTrial& load_;
  const std::vector<PortInfo>& ports_;
  std::vector<Contender> contenders_;
  const StepCheckOptions& options_;
  double end_s_;
  std::vector<std::optional<Settings>> solver_settings_;
  std::vector<std::optional<std::size_t>> last_trial_;  ///< of each contender
  StepCheck check_;
};

}  // namespace

StepCheck check_steps(const LoadTrial& load, const std::vector<PortInfo>& ports,
                      std::vector<Contender> contenders, const StepCheckOptions& options) {
  return Check(load, ports, std::move(contenders), options).run();
}

}  // namespace tandem::orchestrator
