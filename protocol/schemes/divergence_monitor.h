#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/contract/port.h"
#include "protocol/contract/sim_time.h"
#include "protocol/schemes/scheme.h"

namespace tandem {

/// Energy defect of each port over a macro step (J): difference of the interface work that the two
/// sides book, δE = H ((f_Λ − f_λ)·v + (t_Λ − t_λ)·w) at t_n + H, with λ the wrench that moved the
/// multibody side and Λ the flexible side's answer. Positive: the interface created energy.
[[nodiscard]] std::vector<double> energy_defects_J(SimTime H, const MacroStepEnd& end);

/// Whether a step has changed the ports' velocities by round-off alone: in every port the change
/// moves it, over the step, by less than 1e-9 of its distance from the origin and its length,
///   H (|v⁺ − v| + ℓ |w⁺ − w|) ≤ 1e-9 (|p| + ℓ).
/// A model at rest exchanges round-off of its internal forces, K ε |p|, and where an explicit
/// coupling is stable at all, H² K is less than the mass it moves.
[[nodiscard]] bool keeps_its_motion(SimTime H, const MotionSet& begin, const MotionSet& end,
                                    const std::vector<PortInfo>& ports);

/// Detects that a run has left its solution:
///  * a port quantity is not finite, or
///  * the interface energy defect Σ|δE| of a macro step has grown by the factor `growth` since the
///    beginning of an unbroken streak of at least kShortestStreak macro steps with ‖r‖ > ‖λ‖/2
///    which did not keep their motion, where ‖r‖ is the larger one of this and the last macro step:
///    a model at rest exchanges round-off, which is no divergence, and a real one soon moves it.
/// An unstable explicit coupling overshoots every step, λ_{n+1} ≈ −κ λ_n with κ > 1, so its
/// residual exceeds the wrench in every step and its defect grows like κ²; where both sides compute
/// at once it is λ_{n+1} ≈ −κ λ_{n−1}, which overshoots in every other step at least. A stable
/// run's residual is O(H). The text has the ratio ‖Λ‖/‖λ applied‖ of the worst port, which is κ
/// there.
class DivergenceMonitor {
 public:
  DivergenceMonitor(double growth, std::vector<PortInfo> ports);

  /// Text that names the port and the values when the run has diverged with this macro step.
  [[nodiscard]] std::optional<std::string> check(SimTime H, const MacroStepEnd& end);

 private:
  static constexpr std::int64_t kShortestStreak = 5;

  double growth_;
  std::vector<PortInfo> ports_;
  MotionSet last_motions_;  ///< none before the first macro step
  double last_residual_N_ = 0.0;
  std::int64_t streak_ = 0;
  double streak_first_defect_J_ = 0.0;
};

}  // namespace tandem
