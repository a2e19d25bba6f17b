#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "protocol/contract/sim_time.h"
#include "protocol/schemes/coupling_params.h"

namespace tandem {

/// One side's interface Jacobian, ∂out/∂in over a macro step, and when it is asked for anew.
///   EveryStep     at the first evaluation of every macro step;
///   EveryNSteps   of every n-th one;
///   Broyden       once, and then corrected by what every evaluation shows,
///                   J ← J + (Δout − J Δin) Δinᵀ / (Δinᵀ Δin)      [Broyden 1965].
/// The Jacobian belongs to the step's length: another one makes it due.
class JacobianBlock {
 public:
  JacobianBlock(Refresh refresh, std::int32_t every_steps)
      : refresh_(refresh), every_steps_(every_steps) {}

  /// Counts a macro step of H; true when the Jacobian must be asked for.
  [[nodiscard]] bool begin_step(SimTime H);
  /// What the side answered.
  void take(Eigen::MatrixXd jacobian);
  /// Two evaluations from the same state differ by d_in and d_out. True when that changed it.
  bool learn(const Eigen::VectorXd& d_in, const Eigen::VectorXd& d_out);
  [[nodiscard]] const Eigen::MatrixXd& value() const { return value_; }

 private:
  Refresh refresh_;
  std::int32_t every_steps_;
  SimTime step_{};
  std::int32_t age_ = 0;  ///< macro steps since it was taken
  Eigen::MatrixXd value_;
};

}  // namespace tandem
