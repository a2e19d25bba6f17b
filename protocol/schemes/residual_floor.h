#pragma once

#include <cstdint>

namespace tandem {

/// Round-off of the residual as the iterations show it: from some size on it only wavers. A stiff
/// side's own rounding, that of internal forces which cancel in its wrench, stands in no input and
/// no derivative. What the residual wavered at is kept for the next macro steps, which then need no
/// further evaluations to see it.
///
/// Never taken for round-off is more than the largest of 1e-10 of the largest residual or wrench of
/// the macro step or of any accepted wrench before, 100 times what the rounding of the motions
/// makes of the wrench (a stiff mesh adds up that of its nodes), 4 times what the rounding of the
/// poses makes of it where velocities carry the stiffness, and 100 tolerance_N where the scenario
/// sets one (joints may carry far more than the ports). All but the last have the model's own
/// scale. What the flexible side's own solver leaves in the wrench is noise of its own: below it
/// one residual is as good as another, however it has gone up and down.
class ResidualFloor {
 public:
  /// `patience`: evaluations that do not halve the smallest residual of a macro step before it is
  /// taken for round-off.
  ResidualFloor(std::int32_t patience, double tolerance_N)
      : patience_(patience), negligible_N_(100.0 * tolerance_N) {}

  /// `wrench_N`: norm of the wrench at the beginning of the macro step.
  void begin_step(double wrench_N);
  /// Largest norm that begin_step() was given so far.
  [[nodiscard]] double largest_N() const { return largest_N_; }
  /// Whether the residual of the macro step's next evaluation is round-off. ‖Λ‖ is `wrench_N`,
  /// what the rounding of the motions makes of it `round_off_N`, that of the poses `pose_N`,
  /// what the flexible side's solver leaves `solver_N`.
  [[nodiscard]] bool reached(double residual_N, double wrench_N, double round_off_N,
                             double pose_N = 0.0, double solver_N = 0.0);

 private:
  std::int32_t patience_;
  double negligible_N_;
  std::int32_t idle_ = 0;    ///< evaluations since the smallest residual was halved
  double smallest_N_ = 0.0;  ///< of the macro step; 0: none yet
  double largest_N_ = 0.0;   ///< accepted wrench so far
  double scale_N_ = 0.0;     ///< largest residual or wrench of the macro step, or of those accepted
  double floor_N_ = 0.0;     ///< what macro steps wavered at
};

}  // namespace tandem
