#include "protocol/schemes/step_controller.h"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

constexpr double kSafety = 0.9;
constexpr double kMostShrink = 0.3;
constexpr double kMostGrowth = 2.0;
/// Below this an interface is at rest and any step is good.
constexpr double kNegligible_W = 1e-12;

double wrench_defect_W(const MacroStepEnd& end, const WrenchSet& predicted) {
  double sum = 0.0;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    sum += std::abs((end.wrenches[i].f_P_W - predicted[i].f_P_W).dot(end.motions[i].v_WP) +
                    (end.wrenches[i].t_P_W - predicted[i].t_P_W).dot(end.motions[i].w_WP));
  }
  return sum;
}

double motion_defect_W(const MacroStepEnd& end, const MotionSet& predicted) {
  double sum = 0.0;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    sum += end.wrenches[i].f_P_W.norm() * (end.motions[i].v_WP - predicted[i].v_WP).norm() +
           end.wrenches[i].t_P_W.norm() * (end.motions[i].w_WP - predicted[i].w_WP).norm();
  }
  return sum;
}

double power_scale_W(const MacroStepEnd& end) {
  double sum = 0.0;
  for (std::size_t i = 0; i < end.wrenches.size(); ++i) {
    sum += end.wrenches[i].f_P_W.norm() * end.motions[i].v_WP.norm() +
           end.wrenches[i].t_P_W.norm() * end.motions[i].w_WP.norm();
  }
  return sum;
}

}  // namespace

StepController::StepController(const CouplingParams& params, SimTime first_step)
    : coupling_(params),
      converged_(params.scheme == SchemeKind::Implicit ||
                 params.scheme == SchemeKind::InterfaceNewton),
      order_(1.0 + static_cast<double>(converged_ ? params.motion_prediction : params.prediction)),
      shortest_(params.adaptive.min_step.value_or(std::max(first_step / 32, SimTime(1)))),
      longest_(params.adaptive.max_step.value_or(32 * first_step)),
      next_(first_step) {
  next_ = rounded(static_cast<double>(first_step.count()));
}

double StepController::defect_W(SimTime H, const MacroStepEnd& end,
                                const InterfaceState& begin) const {
  if (converged_) {
    return motion_defect_W(end, predict_motions(coupling_.motion_prediction, begin, H));
  }
  return wrench_defect_W(end, predict_wrenches(coupling_.prediction, begin, H));
}

SimTime StepController::rounded(double step_ns) const {
  const auto whole = static_cast<std::int64_t>(step_ns) / shortest_.count();
  return std::clamp(SimTime(whole * shortest_.count()), shortest_, longest_);
}

SimTime StepController::step(SimTime remaining) const { return std::min(next_, remaining); }

bool StepController::accepts(SimTime H, const MacroStepEnd& end, const InterfaceState& begin) {
  const auto H_ns = static_cast<double>(H.count());
  double error = 1.0;
  double largest_power_W = largest_power_W_;
  if (end.outcome == Outcome::Failed || !all_finite(end.motions) || !all_finite(end.wrenches)) {
    error = std::pow(2.0 / kSafety, order_);  // half the step
  } else {
    largest_power_W = std::max(largest_power_W, power_scale_W(end));
    error =
        defect_W(H, end, begin) / (coupling_.adaptive.tolerance * largest_power_W + kNegligible_W);
    if (end.outcome == Outcome::NotConverged) error = std::max(error, std::pow(2.0, order_));
  }
  error = std::max(error, 1e-10);
  if (error > 1.0 && H > shortest_) {
    const double factor = std::max(kMostShrink, kSafety * std::pow(error, -1.0 / order_));
    next_ = std::min(rounded(H_ns * factor), rounded(H_ns - 1.0));
    was_rejected_ = true;
    return false;
  }
  double factor = kSafety * std::pow(error, -0.7 / order_) * std::pow(last_error_, 0.4 / order_);
  factor = std::clamp(factor, kMostShrink, was_rejected_ ? 1.0 : kMostGrowth);
  next_ = rounded(H_ns * factor);
  last_error_ = error;
  largest_power_W_ = largest_power_W;
  was_rejected_ = false;
  return true;
}

}  // namespace tandem
