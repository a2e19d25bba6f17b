#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/newton_path.h"
#include "protocol/schemes/scheme.h"

namespace tandem {
namespace {

/// Evaluations with kept Jacobians after which both sides are linearised anew, at the present
/// iterate: a contact or a limit has switched, or the blocks are too old. Not while an evaluation
/// still lowers the residual to a small part.
constexpr std::int32_t kKeptEvaluations = 4;
constexpr double kFastEvaluation = 0.1;
/// A residual above this part of the wrench after the second evaluation says that the blocks are
/// not those of this step: further steps with them may lead to another solution.
constexpr double kLargeResidual = 1e-2;

std::string newton_remedy_for(double residual_N, double round_off_N, double solver_N) {
  if (auto remedy = solver_remedy(residual_N, round_off_N, solver_N)) return std::move(*remedy);
  if (looks_like_round_off(residual_N, round_off_N)) {
    return fmt::format(
        "The rounding of the port motions makes {:.3g} N of the wrench, and what is left looks "
        "like it: raise coupling.tolerance_N above what is left.",
        round_off_N);
  }
  return "The sides are not affine in the port quantities here (contact, joint limits, large "
         "rotation per step): lower run.macro_step_s or raise coupling.max_iterations.";
}

MacroStepEnd newton_not_converged(MacroStepEnd end, double limit_N, const std::string& remedy) {
  end.outcome = Outcome::NotConverged;
  end.message =
      fmt::format("interface_jacobian: ‖r‖ = {:.3g} N after {} iterations, limit {:.3g} N. {}",
                  end.residual_N, end.iterations, limit_N, remedy);
  return end;
}

/// Secants of the flexible side that are kept: those of some ten macro steps.
constexpr std::size_t kFemSecants = 30;

/// 1 where the side follows the macro step.
std::int64_t micro_steps_of(const FemSide& fem, SimTime H) {
  const SimTime h = fem.info().micro_step;
  return h > SimTime{} ? H / h : 1;
}

/// W of the flexible side's secants: makes all coordinates of a motion squares of m/s, angles as
/// arcs at the port's length.
Eigen::VectorXd motion_weights(const std::vector<PortInfo>& ports, SimTime H) {
  Eigen::VectorXd weights(12 * static_cast<Eigen::Index>(ports.size()));
  const double rate2 = 1.0 / (to_seconds(H) * to_seconds(H));
  for (std::size_t p = 0; p < ports.size(); ++p) {
    const double L2 = ports[p].length_m * ports[p].length_m;
    const Eigen::Vector3d one = Eigen::Vector3d::Ones();
    weights.segment<12>(12 * static_cast<Eigen::Index>(p)) << rate2 * one, rate2 * L2 * one, one,
        L2 * one;
  }
  return weights;
}

}  // namespace

InterfaceJacobianScheme::InterfaceJacobianScheme(const CouplingParams& params,
                                                 std::vector<PortInfo> ports)
    : params_(params),
      ports_(std::move(ports)),
      mbs_block_(params.jacobian.mbs_refresh, params.jacobian.every_steps),
      fem_blocks_(ports_, params.jacobian.fem_refresh, params.jacobian.every_steps, kFemSecants),
      floor_(1, params.tolerance_N) {}

MacroStepEnd InterfaceJacobianScheme::advance(SimTime H, const InterfaceState& state, MbsSide& mbs,
                                              FemSide& fem) {
  NewtonPath path(predict_wrenches(params_.prediction, state, H));
  floor_.begin_step(wrench_norm_N(state.of_bodies(), ports_));
  const MotionSet expected = predict_motions(params_.motion_prediction, state, H);
  fem_blocks_.turn_with(state.motions);
  Linearize linearize{.mbs = mbs_block_.begin_step(H),
                      .fem = fem_blocks_.begin_step(H, micro_steps_of(fem, H))};
  Eigen::PartialPivLU<Eigen::MatrixXd> newton_matrix;
  double round_off_N = 0.0, pose_N = 0.0;
  bool patient = true, changed = true;  // the matrix is to be made anew
  bool fresh = false;                   // the flexible side was linearised in this step
  Evaluation last;
  for (std::int32_t k = 1;; ++k) {
    if (k > 1) roll_back(mbs, fem);
    const WrenchSet lambda = path.lambda();
    Evaluation evaluation = k == 1 ? evaluate_first(H, state, lambda, params_.motion_prediction,
                                                    linearize, mbs, fem, ports_)
                                   : evaluate(H, state, lambda, linearize, mbs, fem, ports_);
    MacroStepEnd end = end_of(evaluation, lambda, k);
    if (end.outcome == Outcome::Failed || !std::isfinite(end.residual_N)) return end;
    if (k < params_.max_iterations && !evaluation.apart &&
        led_astray(H, expected, evaluation.motions) && path.turns_back_from_astray()) {
      linearize.mbs = linearize.fem = path.linearise();
      continue;
    }
    changed |= linearize.mbs || linearize.fem;
    fresh |= linearize.fem;
    if (k > 1) {
      changed |= mbs_block_.learn(stack(lambda) - stack(path.last()),
                                  difference(last.motions, evaluation.motions));
      changed |= fem_blocks_.learn(difference(last.seen, evaluation.seen),
                                   stack(evaluation.wrenches) - stack(last.wrenches),
                                   motion_weights(ports_, H));
    }
    if (linearize.mbs) mbs_block_.take(evaluation.mbs_jacobian);
    if (linearize.fem) fem_blocks_.take(evaluation.fem_jacobian);
    if (k == 1 || linearize.fem) {
      round_off_N = wrench_round_off_N(evaluation.seen, fem_blocks_.value(), ports_);
      pose_N = pose_round_off_N(H, evaluation.seen, fem_blocks_.value(), ports_);
    }
    const Eigen::VectorXd residual = newton_residual(evaluation, fem_blocks_.value());
    const double limit_N = residual_limit_N(params_, evaluation, floor_.largest_N()) + round_off_N;
    if (evaluation.apart) {
      patient = false;
      end.residual_N = wrench_norm_N(unstack_wrenches(residual), ports_);
      if (!std::isfinite(end.residual_N)) return end;
    } else {
      const bool round_off = floor_.reached(end.residual_N, evaluation.wrench_N, round_off_N,
                                            pose_N, evaluation.output_error_N);
      if (end.residual_N <= limit_N || round_off) return end;
      if (ends_on_budget(params_, k)) {
        end.out_of_budget = true;
        return end;
      }
    }
    if (k == params_.max_iterations) {
      const std::string remedy = newton_remedy_for(end.residual_N, std::max(round_off_N, pose_N),
                                                   evaluation.output_error_N);
      return newton_not_converged(std::move(end), limit_N, remedy);
    }
    const double last_N = path.residual_N();
    if (path.turns_back(end.residual_N)) {
      linearize.mbs = linearize.fem = path.linearise();
      continue;
    }
    if (changed) {
      // r(λ + δ) ≈ r(λ) + (L B − I) δ = 0.
      const Eigen::Index n = residual.size();
      newton_matrix.compute(Eigen::MatrixXd::Identity(n, n) -
                            fem_blocks_.value() * mbs_block_.value());
      changed = false;
    }
    if (linearize.fem) path.linearised(end.residual_N);
    path.go(newton_matrix.solve(residual), end.residual_N);
    const bool slow = k > 1 && end.residual_N > kFastEvaluation * last_N;
    const bool lost = slow && !fresh && end.residual_N > kLargeResidual * evaluation.wrench_N;
    linearize.mbs = linearize.fem = lost || (slow && (!patient || k % kKeptEvaluations == 0));
    last = std::move(evaluation);
  }
}

}  // namespace tandem
