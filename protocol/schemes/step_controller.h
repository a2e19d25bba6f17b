#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "protocol/schemes/coupling_params.h"
#include "protocol/schemes/divergence_monitor.h"
#include "protocol/schemes/macro_step.h"
#include "protocol/schemes/prediction.h"

namespace tandem {

/// Chooses the macro step from two estimates of its error, both relative to `tolerance`.
///
/// The position error of the worst port, against the size L of the interface (m): the diagonal of
/// the box around the ports at the start, or the largest port length ℓ where that is more,
///   ε_p = max_ports (‖d‖ + ‖e‖) / (tolerance · L),
///   d = (m⁺ ⊖ m) − H/2 (u + u⁺),    e = H/12 (u⁺ − û),    ‖x‖ = |x_linear| + ℓ |x_angular|,
/// m the pose, u = [v | w] the twist, û its linear prediction. d is what the side's integration
/// differs from the trapezoidal rule: the local error of a first-order step, H²/2 · a. e estimates
/// the error of the trapezoidal rule itself, H³/12 · ȧ. Of order 2 in H.
///
/// Schemes that do not iterate: the interface energy which the step has created (tlm: put into the
/// line) against the largest wrench norm so far over the size,
///   ε_E = H Σ |(f_Λ − f_λ)·v + (t_Λ − t_λ)·w| / (tolerance · L · max ‖Λ‖),
/// λ the wrench that moved the rigid side, Λ the flexible side's answer. Of order 2 or more. A
/// converged step creates none.
///
/// Explicit schemes: the impulse ‖r‖ H that the rigid side has not been given, or too much, against
/// that of the largest wrench so far over the first step H₀ (run.macro_step),
///   ε_r = H ‖r‖ / (H₀ · max ‖Λ‖),
/// whatever the tolerance: a side at rest moves only in the step after, and creates no energy. The
/// next steps give the impulse back as far as they are not shorter.
///
/// With ρ = max(√ε_p, √ε_E, √ε_r), about the step divided by the longest that keeps the tolerance,
/// a step with ρ > 1 is rejected, and the next one is that of a proportional–integral controller
/// [Gustafsson 1991; Söderlind 2002],
///   H ← H · clamp(0.9 ρ_n^(−0.7) ρ_{n−1}^0.4, 0.3, 2),
/// in whole multiples of the shortest step. Integer nanoseconds: the steps are the same in every
/// run.
///
/// An explicit coupling that is unstable swings long before its errors are large. A step that
/// overshoots (‖r‖ > ‖Λ‖/2) and creates four times the energy of the last two is rejected, too.
/// Slower growth a DivergenceMonitor of factor 10 sees: no later step is longer than half of that
/// one.
class StepController {
 public:
  /// `start`: the ports' motions at t = 0.
  StepController(const CouplingParams& params, SimTime first_step, std::vector<PortInfo> ports,
                 const MotionSet& start);

  /// The step to make now, so that the next event or the end of the run, after `remaining`, is met
  /// exactly.
  [[nodiscard]] SimTime step(SimTime remaining) const;

  /// Something begins now, which explicit schemes hear of a step later: theirs is no longer than
  /// the first one.
  void restart() {
    if (explicit_) next_ = std::min(next_, first_);
  }

  /// All steps but the last before an event or the end are whole multiples of it.
  [[nodiscard]] SimTime shortest() const { return shortest_; }

  /// Judges a macro step of H. True = accept. False = make it again, with the shorter step().
  /// A step that failed or did not converge is made again, too, unless it was the shortest.
  /// `begin` is the accepted interface at the beginning of the step.
  bool accepts(SimTime H, const MacroStepEnd& end, const InterfaceState& begin);

  /// Whether the step accepted last was beyond the tolerance: it could not be made shorter.
  [[nodiscard]] bool beyond_tolerance() const { return beyond_tolerance_; }

 private:
  [[nodiscard]] SimTime rounded(double step_ns) const;
  [[nodiscard]] double ratio_of(SimTime H, const MacroStepEnd& end, const InterfaceState& begin,
                                double largest_wrench_N) const;
  [[nodiscard]] bool swings_up(SimTime H, const MacroStepEnd& end,
                               const InterfaceState& begin) const;
  void limit_where_unstable(SimTime H, const MacroStepEnd& end);
  [[nodiscard]] double position_error_m(SimTime H, const MacroStepEnd& end,
                                        const InterfaceState& begin) const;

  CouplingParams coupling_;
  std::vector<PortInfo> ports_;
  bool iterates_;  ///< whether the scheme ends with equal wrenches of both sides
  bool explicit_;
  double size_m_;  ///< L
  DivergenceMonitor monitor_;
  std::array<double, 2> created_J_{};  ///< in the last two accepted steps
  SimTime shortest_, longest_, next_, first_;
  double largest_wrench_N_ = 0.0;
  double last_ratio_ = 1.0;
  bool beyond_tolerance_ = false;
  bool was_rejected_ = false;
};

}  // namespace tandem
