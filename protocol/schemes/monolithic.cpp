#include "protocol/schemes/monolithic.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/newton_path.h"

namespace tandem {
namespace {

/// A residual that no longer falls is round-off when it is below this part of the wrench, or what
/// the rounding of the motions makes, or what the floor knows.
constexpr double kRoundOffResidual = 1e-9;
/// Less than this from one iteration to the next is no Newton step: the port has turned too far.
constexpr double kFast = 0.1;
constexpr std::int32_t kMostIterations = 30;

/// Matrix of the coupled interface system in (δm, δλ).
Eigen::MatrixXd coupled_matrix(const InterfaceJacobian& mbs, const InterfaceJacobian& fem) {
  const Eigen::Index n_m = mbs.rows();
  const Eigen::Index n_l = mbs.cols();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n_m + n_l, n_m + n_l);
  matrix.topRightCorner(n_m, n_l) = -mbs;
  matrix.bottomLeftCorner(n_l, n_m) = -fem;
  return matrix;
}

std::string remedy_for(double residual_N, double round_off_N, double solver_N) {
  if (auto remedy = solver_remedy(residual_N, round_off_N, solver_N)) return std::move(*remedy);
  if (looks_like_round_off(residual_N, round_off_N)) {
    return fmt::format(
        "It wavers about the round-off of the port motions, {:.3g} N of wrench, without repeating: "
        "move the model nearer to the origin, or lower run.macro_step_s.",
        round_off_N);
  }
  return "A joint limit or contact switches within the step: lower run.macro_step_s.";
}

MacroStepEnd not_converged(MacroStepEnd end, double round_off_N, double solver_N) {
  end.outcome = Outcome::NotConverged;
  end.message = fmt::format("monolithic: ‖r‖ = {:.3g} N after {} iterations. {}", end.residual_N,
                            end.iterations, remedy_for(end.residual_N, round_off_N, solver_N));
  return end;
}

}  // namespace

MacroStepEnd MonolithicStep::advance(SimTime H, const InterfaceState& state, MbsSide& mbs,
                                     FemSide& fem) {
  NewtonPath path(predict_wrenches(Prediction::Linear, state, H));
  Eigen::PartialPivLU<Eigen::MatrixXd> coupled;
  double round_off_N = 0.0, pose_N = 0.0;
  double smallest_N = std::numeric_limits<double>::infinity();
  bool linearize = true;
  floor_.begin_step(wrench_norm_N(state.of_bodies(), ports_));
  const MotionSet expected = predict_motions(Prediction::Linear, state, H);
  for (std::int32_t k = 1;; ++k) {
    if (k > 1) roll_back(mbs, fem);
    const WrenchSet lambda = path.lambda();
    const Linearize both{.mbs = linearize, .fem = linearize};
    const Evaluation evaluation =
        k == 1 ? evaluate_first(H, state, lambda, Prediction::Linear, both, mbs, fem, ports_)
               : evaluate(H, state, lambda, both, mbs, fem, ports_);
    MacroStepEnd end = end_of(evaluation, lambda, k);
    if (end.outcome == Outcome::Failed || !std::isfinite(end.residual_N)) return end;
    if (k < kMostIterations && !evaluation.apart && led_astray(H, expected, evaluation.motions) &&
        path.turns_back_from_astray()) {
      linearize = path.linearise();
      continue;
    }
    if (linearize) {
      coupled.compute(coupled_matrix(evaluation.mbs_jacobian, evaluation.fem_jacobian));
      round_off_N = wrench_round_off_N(evaluation.seen, evaluation.fem_jacobian, ports_);
      pose_N = pose_round_off_N(H, evaluation.seen, evaluation.fem_jacobian, ports_);
    }
    Eigen::VectorXd residual = evaluation.residual;
    if (evaluation.apart) {
      residual = newton_residual(evaluation, evaluation.fem_jacobian);
      end.residual_N = wrench_norm_N(unstack_wrenches(residual), ports_);
      if (!std::isfinite(end.residual_N)) return end;
    }
    // Newton's residual falls by orders of magnitude until round-off; then it only wavers.
    const bool falls = end.residual_N <= kFast * smallest_N;
    const bool small =
        end.residual_N <= std::max(round_off_N, kRoundOffResidual * evaluation.wrench_N);
    const bool wavers =
        !evaluation.apart && floor_.reached(end.residual_N, evaluation.wrench_N, round_off_N,
                                            pose_N, evaluation.output_error_N);
    const bool ended = end.residual_N == 0.0 || (small && !falls) || wavers;
    if (ended && !evaluation.apart) return end;
    if (k == kMostIterations) {
      return not_converged(std::move(end), std::max(round_off_N, pose_N),
                           evaluation.output_error_N);
    }
    if (path.turns_back(end.residual_N)) {
      linearize = path.linearise();
      continue;
    }
    if (linearize) path.linearised(end.residual_N);
    linearize = !falls;
    smallest_N = std::min(smallest_N, end.residual_N);
    const Eigen::Index n_l = residual.size();
    const Eigen::Index n_m = 2 * n_l;
    Eigen::VectorXd right_side = Eigen::VectorXd::Zero(n_m + n_l);
    right_side.tail(n_l) = residual;
    path.go(coupled.solve(right_side).tail(n_l), end.residual_N);
  }
}

}  // namespace tandem
