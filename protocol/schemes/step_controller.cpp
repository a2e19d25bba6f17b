#include "protocol/schemes/step_controller.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem {
namespace {

constexpr double kSafety = 0.9;
constexpr double kMostShrink = 0.3;
constexpr double kMostGrowth = 2.0;
/// Of the interface energy over a streak of steps that overshoot.
constexpr double kUnstableGrowth = 10.0;
/// Of the interface energy from one step that overshoots to the next: fewer such steps than a
/// streak is long make the run diverge.
constexpr double kMostSwing = 4.0;
/// A step much too short says little of how much longer the next may be.
constexpr double kLeastRatio = 1e-5;

/// Interface energy that the step has made or lost.
double created_J(SimTime H, const MacroStepEnd& end) {
  double sum_J = 0.0;
  for (const double defect_J : energy_defects_J(H, end)) sum_J += std::abs(defect_J);
  return sum_J;
}

/// The diagonal of the box around the ports, or the largest port length where that is more.
double size_m(const std::vector<PortInfo>& ports, const MotionSet& motions) {
  Eigen::AlignedBox3d box;
  for (const Motion& motion : motions) box.extend(motion.p_WP);
  double size = motions.empty() ? 0.0 : box.diagonal().norm();
  for (const PortInfo& port : ports) size = std::max(size, port.length_m);
  return size;
}

}  // namespace

StepController::StepController(const CouplingParams& params, SimTime first_step,
                               std::vector<PortInfo> ports, const MotionSet& start)
    : coupling_(params),
      ports_(std::move(ports)),
      iterates_(params.scheme == SchemeKind::Implicit ||
                params.scheme == SchemeKind::InterfaceNewton),
      explicit_(params.scheme == SchemeKind::ExplicitSerial ||
                params.scheme == SchemeKind::ExplicitParallel),
      size_m_(size_m(ports_, start)),
      monitor_(kUnstableGrowth, ports_),
      shortest_(params.adaptive.min_step.value_or(std::max(first_step / 32, SimTime(1)))),
      longest_(params.adaptive.max_step.value_or(32 * first_step)),
      next_(first_step),
      first_(first_step) {
  next_ = first_ = rounded(static_cast<double>(first_step.count()));
}

double StepController::position_error_m(SimTime H, const MacroStepEnd& end,
                                        const InterfaceState& begin) const {
  const double H_s = to_seconds(H);
  const Eigen::VectorXd moved = difference(begin.motions, end.motions);
  const Eigen::VectorXd u = twists(begin.motions);
  const Eigen::VectorXd u_end = twists(end.motions);
  const Eigen::VectorXd d_u = u_end - twists(predict_motions(Prediction::Linear, begin, H));
  double worst_m = 0.0;
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const auto norm_m = [&](const Eigen::Matrix<double, 6, 1>& x) {
      return x.head<3>().norm() + ports_[i].length_m * x.tail<3>().norm();
    };
    const Eigen::Matrix<double, 6, 1> d =
        moved.segment<6>(12 * k) - 0.5 * H_s * (u.segment<6>(6 * k) + u_end.segment<6>(6 * k));
    worst_m = std::max(worst_m, norm_m(d) + norm_m(H_s / 12.0 * d_u.segment<6>(6 * k)));
  }
  return worst_m;
}

SimTime StepController::rounded(double step_ns) const {
  const auto whole = static_cast<std::int64_t>(step_ns) / shortest_.count();
  return std::clamp(SimTime(whole * shortest_.count()), shortest_, longest_);
}

SimTime StepController::step(SimTime remaining) const {
  // Two equal steps at the end, not a long one and a rest, however short.
  if (next_ < remaining && remaining < 2 * next_)
    return rounded(0.5 * static_cast<double>(remaining.count()));
  return std::min(next_, remaining);
}

double StepController::ratio_of(SimTime H, const MacroStepEnd& end, const InterfaceState& begin,
                                double largest_wrench_N) const {
  const double allowed_m = coupling_.adaptive.tolerance * size_m_;
  double error = position_error_m(H, end, begin) / allowed_m;
  const double defect_J = iterates_ ? 0.0 : created_J(H, end);
  // Without any wrench there is none.
  if (defect_J > 0.0) error = std::max(error, defect_J / (allowed_m * largest_wrench_N));
  if (explicit_ && end.residual_N > 0.0) {
    const double steps = to_seconds(H) / to_seconds(first_);
    error = std::max(error, steps * end.residual_N / largest_wrench_N);
  }
  return std::sqrt(error);
}

bool StepController::swings_up(SimTime H, const MacroStepEnd& end,
                               const InterfaceState& begin) const {
  const double before_J = std::max(created_J_[0], created_J_[1]);
  return explicit_ && before_J > 0.0 && !keeps_its_motion(H, begin.motions, end.motions, ports_) &&
         end.residual_N > 0.5 * wrench_norm_N(end.of_bodies(), ports_) &&
         created_J(H, end) > kMostSwing * before_J;
}

void StepController::limit_where_unstable(SimTime H, const MacroStepEnd& end) {
  created_J_ = {created_J(H, end), created_J_[0]};
  if (!monitor_.check(H, end)) return;
  longest_ = rounded(0.5 * static_cast<double>(H.count()));
  monitor_ = DivergenceMonitor(kUnstableGrowth, ports_);
}

bool StepController::accepts(SimTime H, const MacroStepEnd& end, const InterfaceState& begin) {
  const auto H_ns = static_cast<double>(H.count());
  // Shorter than wanted, to end at an event: it says little of the steps after.
  const bool cut_short = H < next_;
  double ratio = 2.0 / kSafety;  // half the step
  double largest_wrench_N = largest_wrench_N_;
  const bool known =
      end.outcome != Outcome::Failed && all_finite(end.motions) && all_finite(end.wrenches);
  if (known) {
    largest_wrench_N = std::max(largest_wrench_N, wrench_norm_N(end.of_bodies(), ports_));
    ratio = ratio_of(H, end, begin, largest_wrench_N);
    if (end.outcome == Outcome::NotConverged || swings_up(H, end, begin))
      ratio = std::max(ratio, 2.0);
  }
  ratio = std::max(ratio, kLeastRatio);
  if (ratio > 1.0 && H > shortest_) {
    const double factor = std::max(kMostShrink, kSafety / ratio);
    next_ = std::min(rounded(H_ns * factor), rounded(H_ns - 1.0));
    was_rejected_ = true;
    return false;
  }
  if (explicit_ && known) limit_where_unstable(H, end);
  beyond_tolerance_ = ratio > 1.0;
  if (!cut_short || beyond_tolerance_) {
    double factor = kSafety * std::pow(ratio, -0.7) * std::pow(last_ratio_, 0.4);
    factor = std::clamp(factor, kMostShrink, was_rejected_ ? 1.0 : kMostGrowth);
    next_ = rounded(H_ns * factor);
    last_ratio_ = ratio;
  }
  largest_wrench_N_ = largest_wrench_N;
  was_rejected_ = false;
  return true;
}

}  // namespace tandem
