#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "protocol/contract/port.h"
#include "protocol/contract/sim_time.h"
#include "protocol/schemes/coupling_params.h"

namespace tandem {

/// One side's interface Jacobian, ∂out/∂in over a macro step, and when it is asked for anew.
///   EveryStep     at the first evaluation of every macro step;
///   EveryNSteps   of every n-th one;
///   Broyden       once, and then corrected by what every evaluation shows: in turn for the last
///                 secants (Δin_k, Δout_k), newest first,
///                   J ← J + (Δout_k − J Δin_k) q_kᵀ W / (q_kᵀ W q_k),
///                 q_k what Δin_k has that is W-orthogonal to the newer ones, so that J maps all of
///                 them right; with one secant Broyden's update [Broyden 1965; Fang & Saad 2009].
/// The Jacobian belongs to the step's length: another one makes it due.
class JacobianBlock {
 public:
  /// Broyden: `secants` are kept, from macro step to macro step.
  JacobianBlock(Refresh refresh, std::int32_t every_steps, std::size_t secants = 1)
      : refresh_(refresh), every_steps_(every_steps), most_secants_(secants) {}

  /// Counts a macro step of H, which the side makes in so many micro steps; true when the Jacobian
  /// must be asked for.
  [[nodiscard]] bool begin_step(SimTime H, std::int64_t micro_steps = 1);
  /// Turns what is kept of every port with its frame, from where it stood at the last call: in the
  /// axes of its ports a flexible body's Jacobian hardly changes.
  void turn_with(const MotionSet& motions);
  /// What the side answered.
  void take(Eigen::MatrixXd jacobian);
  /// Two evaluations from the same state differ by d_in and d_out. W = diag(weights), which make
  /// the coordinates of the input comparable. True when that changed the Jacobian.
  bool learn(const Eigen::VectorXd& d_in, const Eigen::VectorXd& d_out,
             const Eigen::VectorXd& weights);
  /// The same with W = 1.
  bool learn(const Eigen::VectorXd& d_in, const Eigen::VectorXd& d_out);
  [[nodiscard]] const Eigen::MatrixXd& value() const { return value_; }

 private:
  struct Secant {
    Eigen::VectorXd in;
    Eigen::VectorXd out;
  };

  Refresh refresh_;
  bool learns_ = false;
  std::int32_t every_steps_;
  std::size_t most_secants_;
  SimTime step_{};
  std::int32_t age_ = 0;  ///< macro steps since it was taken
  Eigen::MatrixXd value_;
  std::deque<Secant> secants_;  ///< newest first
  MotionSet stood_;             ///< the ports' motions at the last turn_with()
};

}  // namespace tandem
