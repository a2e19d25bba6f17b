#pragma once

#include <cstdint>
#include <vector>

#include "protocol/schemes/coupling_params.h"
#include "protocol/schemes/macro_step.h"
#include "protocol/schemes/prediction.h"

namespace tandem {

/// Chooses the macro step from the energy defect of the prediction, whatever the scheme:
///   ε = Σ_ports |(f_Λ − f_λ̂)·v + (t_Λ − t_λ̂)·w| / (tolerance · P),
/// λ̂ the predicted wrench, Λ the accepted one, P = max over the run of Σ |f||v| + |t||w|: the power
/// that an explicit step would have created, relative to what passes the interface. It is of order
/// p = 1, 2, 3 in H for hold, linear, quadratic prediction. A step with ε > 1 is rejected. The next
/// step is that of a proportional–integral controller [Gustafsson 1991; Söderlind 2002],
///   H ← H · clamp(0.9 ε_n^(−0.7/p) ε_{n−1}^(0.4/p), 0.3, 2),
/// in whole multiples of the shortest step. Integer nanoseconds: the steps are the same in every
/// run.
class StepController {
 public:
  StepController(const AdaptiveParams& params, Prediction prediction, SimTime first_step);

  /// The step to make now, so that the end of the run is met exactly.
  [[nodiscard]] SimTime step(SimTime remaining) const;

  /// Judges a macro step of H. True = accept. False = make it again, with the shorter step().
  /// A step that failed or did not converge is made again, too, unless it was the shortest.
  bool accepts(SimTime H, const MacroStepEnd& end, const WrenchSet& predicted);

 private:
  [[nodiscard]] SimTime rounded(double step_ns) const;

  AdaptiveParams params_;
  double order_;
  SimTime shortest_, longest_, next_;
  double largest_power_W_ = 0.0;
  double last_error_ = 1.0;
  bool was_rejected_ = false;
};

}  // namespace tandem
