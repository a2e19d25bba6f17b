#pragma once

#include <cstdint>
#include <vector>

#include "protocol/schemes/coupling_params.h"
#include "protocol/schemes/macro_step.h"
#include "protocol/schemes/prediction.h"

namespace tandem {

/// Chooses the macro step from the interface energy that the prediction has got wrong, as a power
/// relative to the largest that has passed the ports so far, P = max Σ_ports |f||v| + |t||w|:
///   explicit schemes   ε = Σ |(f_Λ − f_λ̂)·v + (t_Λ − t_λ̂)·w| / (tolerance · P),
/// the energy which the step has created, λ̂ the predicted wrench, Λ the answer to it;
///   converged schemes  ε = Σ (|f_Λ||v − v̂| + |t_Λ||w − ŵ|) / (tolerance · P),
/// v̂, ŵ the predicted velocities: a converged step creates none, and its wrenches may carry waves
/// that no step resolves, whose prediction would not become better with shorter steps.
/// Of order p = 1, 2, 3 in H for hold, linear, quadratic prediction (motion_prediction where
/// motions are compared). A step with ε > 1 is rejected. The next step is that of a
/// proportional–integral controller [Gustafsson 1991; Söderlind 2002],
///   H ← H · clamp(0.9 ε_n^(−0.7/p) ε_{n−1}^(0.4/p), 0.3, 2),
/// in whole multiples of the shortest step. Integer nanoseconds: the steps are the same in every
/// run.
class StepController {
 public:
  StepController(const CouplingParams& params, SimTime first_step);

  /// The step to make now, so that the end of the run is met exactly.
  [[nodiscard]] SimTime step(SimTime remaining) const;

  /// Judges a macro step of H. True = accept. False = make it again, with the shorter step().
  /// A step that failed or did not converge is made again, too, unless it was the shortest.
  /// `begin` is the accepted interface at the beginning of the step.
  bool accepts(SimTime H, const MacroStepEnd& end, const InterfaceState& begin);

  /// Whether the step accepted last was beyond the tolerance: it could not be made shorter.
  [[nodiscard]] bool beyond_tolerance() const { return last_error_ > 1.0; }

 private:
  [[nodiscard]] SimTime rounded(double step_ns) const;
  [[nodiscard]] double defect_W(SimTime H, const MacroStepEnd& end,
                                const InterfaceState& begin) const;

  CouplingParams coupling_;
  bool converged_;  ///< whether the scheme iterates until both sides agree
  double order_;
  SimTime shortest_, longest_, next_;
  double largest_power_W_ = 0.0;
  double last_error_ = 1.0;
  bool was_rejected_ = false;
};

}  // namespace tandem
