#pragma once

#include <cstdint>
#include <limits>
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

/// What a DivergenceMonitor has seen.
struct Divergence {
  std::string text;  ///< port and values
  /// Factor by which the residual has grown per macro step, |z|; 0: a value is not finite.
  double growth_per_step = 0.0;
  /// What the interface has made in the macro step (J).
  double defect_J = std::numeric_limits<double>::infinity();
};

/// The ratio κ of the flexible side's effective mass (with H² times its stiffness) to the rigid
/// one's at which an error of the wrench grows by |z| per macro step in explicit_serial, z = −|z|
/// in
///   hold z = −κ,   linear z² = −κ (2z − 1),   quadratic z³ = −κ (3z² − 3z + 1).
/// |z| = 1 gives the limits 1, 1/3 and 1/7.
[[nodiscard]] double ratio_of_growth(double growth_per_step, Prediction prediction);

/// Detects that a run has left its solution:
///  * a port quantity is not finite, or
///  * the interface energy defect Σ|δE| of a macro step has grown by the factor `growth` since the
///    beginning of an unbroken streak of at least kShortestStreak macro steps with ‖r‖ > ‖λ‖/2
///    which did not keep their motion, where ‖r‖ is the larger one of this and the last macro step:
///    a model at rest exchanges round-off, which is no divergence, and a real one soon moves it.
/// An unstable explicit coupling overshoots every step, λ_{n+1} ≈ −κ λ_n with κ > 1, so its
/// residual exceeds the wrench in every step and its defect grows like κ²; where both sides compute
/// at once it is λ_{n+1} ≈ −κ λ_{n−1}, which overshoots in every other step at least. A stable
/// run's residual is O(H).
class DivergenceMonitor {
 public:
  DivergenceMonitor(double growth, std::vector<PortInfo> ports);

  /// Port and values when the run has diverged with this macro step.
  [[nodiscard]] std::optional<Divergence> check(SimTime H, const MacroStepEnd& end);

 private:
  static constexpr std::int64_t kShortestStreak = 5;

  double growth_;
  std::vector<PortInfo> ports_;
  MotionSet last_motions_;  ///< none before the first macro step
  double last_residual_N_ = 0.0;
  std::int64_t streak_ = 0;
  double streak_first_defect_J_ = 0.0;
  double streak_first_residual_N_ = 0.0;
};

}  // namespace tandem
