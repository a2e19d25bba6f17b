#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace tandem::orchestrator {

/// What the trial runs of a candidate measured, at a step and at half of it.
struct TrialNumbers {
  bool solved = false;  ///< with the step
  double step_s = 0.0;
  double error_m = 0.0;       ///< of the port motion, against a fine run
  double half_error_m = 0.0;  ///< with half the step; 0: not measured
  double wall_per_step_s = 0.0;
};

/// What bounds the step of a candidate.
struct ChoiceLimits {
  double wanted_m = 0.0;           ///< error that is asked for
  double reference_error_m = 0.0;  ///< errors below it are not known
  double longest_s = 0.0, shortest_s = 0.0;
  double run_s = 0.0;  ///< length of the run, which should be a whole number of steps
};

/// A candidate at the step that its trial runs promise the wanted error for.
struct Prospect {
  bool known = false;  ///< whether the trial runs tell an error to choose a step by
  double order = 0.0;
  double step_s = 0.0;      ///< 0: not to be chosen
  double wall_per_s = 0.0;  ///< wall time per simulated second at that step
};

/// From e(H) = c Hᵖ with p = log2(e(H)/e(H/2)), kept between 1/2 and 3: H (wanted/e)^(1/p).
[[nodiscard]] Prospect prospect_of(const TrialNumbers& trial, const ChoiceLimits& limits);

/// The prospect with the least wall time per simulated second, of which `own`, the scenario's,
/// needs no more than a tenth more than the least: so much is no difference of measured times.
/// None: all have been given up.
[[nodiscard]] std::optional<std::size_t> cheapest(const std::vector<Prospect>& prospects,
                                                  std::optional<std::size_t> own);

/// What speaks against a step, from a run with it: a value above what is allowed.
struct Objection {
  std::string
      name;  ///< "not_solved", "accuracy", "elastic_peak", "wrench_peak", or a cause of the verdict
  double value = 0.0;
  double limit = 0.0;
  double power = 1.0;  ///< the value falls with H to this power
  std::string text;    ///< what was seen
  std::string remedy;  ///< an imperative sentence; empty: shorter steps
};

/// The step that the objections ask for, of the form of nice_step_below: half of it or less, and
/// not below a fiftieth, further than which one run does not reach.
[[nodiscard]] double shortened(double step_s, const std::vector<Objection>& objections,
                               double run_s);

/// Whether an objection stands as it did with a longer step, though the step was halved at least:
/// then no shorter one cures it, and it is told and not acted upon.
[[nodiscard]] bool stubborn(const Objection& now, double step_s,
                            const std::vector<Objection>& before, double before_step_s);

/// How bad a run is: 0 nothing to object to, 1 less accurate than asked for, 2 a verdict that is
/// not clean or a body that is not resolved, 3 not solved.
[[nodiscard]] int severity(const std::vector<Objection>& objections);

/// A run that was made, for the comparison of the recommendation with the scenario's own settings.
struct Standing {
  bool whole = false;  ///< it came to its end
  double wall_per_s = 0.0;
  double error = 0.0;  ///< of the travel
  int severity = 0;
};

/// Whether the scenario's own settings do what is asked for at no more wall time.
[[nodiscard]] bool own_is_better(const Standing& own, const Standing& recommended, double accuracy);

/// The next smaller number of the form 1, 2, 5 × 10ⁿ.
[[nodiscard]] double nice_below(double value);
/// The largest of these of which the run is a whole number; nice_below(value) where there is none
/// down to a tenth of the value.
[[nodiscard]] double nice_step_below(double value, double run_s);
/// Whether `run_s` is a whole number of steps, of a whole number of nanoseconds each.
[[nodiscard]] bool divides(double step_s, double run_s);

}  // namespace tandem::orchestrator
