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

/// Detects that a run has left its solution:
///  * a port quantity is not finite, or
///  * the interface energy defect Σ|δE| of a macro step has grown by the factor `growth` since the
///    beginning of an unbroken streak of at least kShortestStreak macro steps with ‖r‖ > ‖λ‖/2
///    and ‖r‖ > kNegligible_N, where ‖r‖ is the larger one of this and the last macro step: a model
///    at rest exchanges round-off, which is no divergence, and a real one soon grows past that
///    bound.
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
  static constexpr double kNegligible_N = 1e-6;

  double growth_;
  std::vector<PortInfo> ports_;
  double last_residual_N_ = 0.0;
  std::int64_t streak_ = 0;
  double streak_first_defect_J_ = 0.0;
};

}  // namespace tandem
