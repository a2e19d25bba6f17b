#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/scheme.h"

namespace tandem {
namespace {

/// Weights of stacked wrenches in wrench_norm_N: 1 for forces, 1/L for torques.
Eigen::VectorXd wrench_weights(const std::vector<PortInfo>& ports) {
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(6 * static_cast<Eigen::Index>(ports.size()));
  for (std::size_t i = 0; i < ports.size(); ++i) {
    weights.segment<3>(6 * static_cast<Eigen::Index>(i) + 3).setConstant(1.0 / ports[i].length_m);
  }
  return weights;
}

/// Weights of differences of motions: those of motion_norm_m_per_s for velocities. Poses follow
/// from velocities but for what the integrators make of them, and their rounding over H is far
/// larger: at a weight of 1 it would hide what the last evaluations tell.
Eigen::VectorXd motion_weights(const std::vector<PortInfo>& ports, double H_s) {
  constexpr double kPose = 1e-3;
  Eigen::VectorXd weights(12 * static_cast<Eigen::Index>(ports.size()));
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const auto row = 12 * static_cast<Eigen::Index>(i);
    const double length = ports[i].length_m;
    weights.segment<3>(row).setConstant(kPose / H_s);
    weights.segment<3>(row + 3).setConstant(kPose * length / H_s);
    weights.segment<3>(row + 6).setOnes();
    weights.segment<3>(row + 9).setConstant(length);
  }
  return weights;
}

/// Norm of the velocities in a difference of motions alone: what convergence is judged by. Poses
/// follow from them, but their rounding, divided by H, may exceed any tolerance.
double twist_norm_m_per_s(Eigen::VectorXd xi, const std::vector<PortInfo>& ports) {
  for (Eigen::Index row = 0; row < xi.size(); row += 12) xi.segment<6>(row).setZero();
  return motion_norm_m_per_s(xi, ports, 1.0);
}

double twist_norm_m_per_s(const MotionSet& motions, const std::vector<PortInfo>& ports) {
  return twist_norm_m_per_s(difference(MotionSet(motions.size()), motions), ports);
}

/// Largest ‖Δ velocity of the multibody side's answer‖/‖Δλ‖/H so far (1/kg): what an error of the
/// wrench makes of the velocities. A velocity near zero has no relative tolerance of its own.
class Admittance {
 public:
  /// `kept_per_kg` goes on from macro step to macro step.
  Admittance(const std::vector<PortInfo>& ports, double H_s, double& kept_per_kg)
      : ports_(ports), H_s_(H_s), kept_per_kg_(kept_per_kg) {}

  void observe(const WrenchSet& lambda, const MotionSet& answer) {
    if (!lambda_.empty()) {
      const Eigen::VectorXd change = stack(lambda) - stack(lambda_);
      const double change_N = wrench_norm_N(unstack_wrenches(change), ports_);
      // Smaller changes are round-off themselves.
      if (change_N > 1e-9 * wrench_norm_N(lambda, ports_)) {
        const double change_m_per_s = twist_norm_m_per_s(difference(answer_, answer), ports_);
        kept_per_kg_ = std::max(kept_per_kg_, change_m_per_s / (change_N * H_s_));
      }
    }
    lambda_ = lambda;
    answer_ = answer;
  }
  [[nodiscard]] double s_per_kg() const { return kept_per_kg_ * H_s_; }

 private:
  const std::vector<PortInfo>& ports_;
  double H_s_;
  double& kept_per_kg_;
  WrenchSet lambda_;
  MotionSet answer_;
};

/// What the rounding of motions makes of the wrenches that answer them: ε ‖m‖ times the largest
/// ‖ΔΛ‖/‖Δm‖ of a macro step's evaluations. With short steps an inertia over H makes that more than
/// a tolerance, and no iterate comes closer but by accident.
class RoundOff {
 public:
  explicit RoundOff(const std::vector<PortInfo>& ports) : ports_(ports) {}

  void observe(const MotionSet& motions, const WrenchSet& answer) {
    if (!motions_.empty()) {
      const double change = twist_norm_m_per_s(difference(motions_, motions), ports_);
      // Smaller changes are round-off themselves.
      if (change > 1e-9 * twist_norm_m_per_s(motions, ports_)) {
        const Eigen::VectorXd gap = stack(answer) - stack(answer_);
        gain_ = std::max(gain_, wrench_norm_N(unstack_wrenches(gap), ports_) / change);
      }
    }
    motions_ = motions;
    answer_ = answer;
  }
  /// In the residual norm. 16: an iterate's roundings, as a difference, a sum and a quotient.
  [[nodiscard]] double size_N() const {
    constexpr double kUnit = std::numeric_limits<double>::epsilon();
    return 16.0 * kUnit * gain_ * twist_norm_m_per_s(motions_, ports_);
  }
  /// With that of the poses over H, which a stiff side feels and a heavy one does not: how much of
  /// it there is the evaluations do not tell.
  [[nodiscard]] double most_N(double H_s) const {
    double sum_m2 = 0.0;
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      sum_m2 += motions_[i].p_WP.squaredNorm() + std::pow(ports_[i].length_m, 2);
    }
    return size_N() + std::numeric_limits<double>::epsilon() * gain_ * std::sqrt(sum_m2) / H_s;
  }

 private:
  const std::vector<PortInfo>& ports_;
  MotionSet motions_;
  WrenchSet answer_;
  double gain_ = 0.0;  ///< kg/s
};

MacroStepEnd not_converged(MacroStepEnd end, const CouplingParams& params,
                           const std::string& residual) {
  end.outcome = Outcome::NotConverged;
  end.message = fmt::format(
      "implicit: {} after {} iterations. Raise coupling.max_iterations, use coupling.relaxation: "
      "iqn_ils, lower coupling.relaxation_factor or run.macro_step_s, or use coupling.scheme: "
      "interface_jacobian.",
      residual, params.max_iterations);
  return end;
}

bool cannot_go_on(const MacroStepEnd& end) {
  return end.outcome == Outcome::Failed || !std::isfinite(end.residual_N);
}

}  // namespace

Implicit::Implicit(const CouplingParams& params, std::vector<PortInfo> ports)
    : params_(params),
      ports_(std::move(ports)),
      accelerator_(make_accelerator(params)),
      // Slow relaxation halves a residual in a few evaluations.
      floor_(8, params.tolerance_N) {}

MacroStepEnd Implicit::advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) {
  const bool accepted = begun_ && state.time > *begun_;
  begun_ = state.time;
  floor_.begin_step(wrench_norm_N(state.of_bodies(), ports_));
  if (params_.iteration == Iteration::Parallel) return in_parallel(H, state, accepted, mbs, fem);
  return in_turn(H, state, accepted, mbs, fem);
}

MacroStepEnd Implicit::in_turn(SimTime H, const InterfaceState& state, bool accepted, MbsSide& mbs,
                               FemSide& fem) {
  WrenchSet lambda = predict_wrenches(params_.prediction, state, H);
  accelerator_->begin_step(wrench_weights(ports_), accepted);
  RoundOff round_off(ports_);
  for (std::int32_t k = 1;; ++k) {
    if (k > 1) roll_back(mbs, fem);
    const Evaluation evaluation = evaluate(H, state, lambda, {}, mbs, fem, ports_);
    MacroStepEnd end = end_of(evaluation, lambda, k);
    if (cannot_go_on(end)) return end;
    accelerator_->observe(stack(lambda), evaluation.residual);
    round_off.observe(evaluation.motions, evaluation.wrenches);
    const double limit_N =
        std::max(residual_limit_N(params_, evaluation, floor_.largest_N()), round_off.size_N());
    const bool at_floor =
        floor_.reached(end.residual_N, evaluation.wrench_N, round_off.most_N(to_seconds(H)), 0.0,
                       evaluation.output_error_N);
    if (end.residual_N <= limit_N || at_floor) return end;
    end.out_of_budget = ends_on_budget(params_, k);
    if (end.out_of_budget) return end;
    if (k == params_.max_iterations) {
      return not_converged(
          std::move(end), params_,
          fmt::format("‖r‖ = {:.3g} N, limit {:.3g} N", evaluation.residual_N, limit_N));
    }
    lambda = unstack_wrenches(accelerator_->next());
  }
}

MacroStepEnd Implicit::in_parallel(SimTime H, const InterfaceState& state, bool accepted,
                                   MbsSide& mbs, FemSide& fem) {
  WrenchSet lambda = predict_wrenches(params_.prediction, state, H);
  MotionSet motions = predict_motions(params_.motion_prediction, state, H);
  const Eigen::Index n_l = 6 * static_cast<Eigen::Index>(ports_.size());
  const Eigen::Index n_m = 2 * n_l;
  Eigen::VectorXd x(n_m + n_l), r(n_m + n_l);
  RoundOff round_off(ports_);
  Admittance admittance(ports_, to_seconds(H), admittance_per_kg_);
  // A port that turns back within the step has the velocity that it had.
  const double begin_m_per_s = twist_norm_m_per_s(state.motions, ports_);
  for (std::int32_t k = 1;; ++k) {
    if (k > 1) roll_back(mbs, fem);
    const Evaluation evaluation = evaluate_parallel(H, state, lambda, motions, mbs, fem, ports_);
    MacroStepEnd end = end_of(evaluation, lambda, k);
    if (cannot_go_on(end)) return end;
    // Motions count from the beginning of the step, where they are an ordinary vector.
    x << difference(state.motions, motions), stack(lambda);
    r << difference(state.motions, evaluation.motions) - x.head(n_m), evaluation.residual;
    if (k == 1) {
      Eigen::VectorXd weights(n_m + n_l);
      weights << motion_weights(ports_, to_seconds(H)), wrench_weights(ports_);
      // Newtons for metres per second: both parts of the first residual count the same.
      const double size_m = weights.head(n_m).cwiseProduct(r.head(n_m)).norm();
      if (size_m > 0.0 && end.residual_N > 0.0) weights.head(n_m) *= end.residual_N / size_m;
      accelerator_->begin_step(weights, accepted);
    }
    round_off.observe(motions, evaluation.wrenches);
    admittance.observe(lambda, evaluation.motions);
    accelerator_->observe(x, r);
    const double limit_N =
        std::max(residual_limit_N(params_, evaluation, floor_.largest_N()), round_off.size_N());
    const double residual_m_per_s = twist_norm_m_per_s(r.head(n_m), ports_);
    const bool at_floor =
        floor_.reached(end.residual_N, evaluation.wrench_N, round_off.most_N(to_seconds(H)), 0.0,
                       evaluation.output_error_N);
    const bool same_wrench = end.residual_N <= limit_N || at_floor;
    const double limit_m_per_s =
        params_.tolerance_m_per_s +
        params_.relative_tolerance *
            std::max(twist_norm_m_per_s(evaluation.motions, ports_), begin_m_per_s) +
        admittance.s_per_kg() * (at_floor ? std::max(limit_N, end.residual_N) : limit_N);
    if (same_wrench && residual_m_per_s <= limit_m_per_s) return end;
    end.out_of_budget = ends_on_budget(params_, k);
    if (end.out_of_budget) return end;
    if (k == params_.max_iterations) {
      return not_converged(std::move(end), params_,
                           fmt::format("‖r‖ = {:.3g} N, limit {:.3g} N, and {:.3g} m/s, limit "
                                       "{:.3g} m/s",
                                       end.residual_N, limit_N, residual_m_per_s, limit_m_per_s));
    }
    x = accelerator_->next();
    motions = displaced(state.motions, x.head(n_m));
    lambda = unstack_wrenches(x.tail(n_l));
  }
}

}  // namespace tandem
