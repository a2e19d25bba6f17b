#include "protocol/schemes/divergence_monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem {

std::vector<double> energy_defects_J(SimTime H, const MacroStepEnd& end) {
  std::vector<double> defects(end.wrenches.size());
  for (std::size_t i = 0; i < defects.size(); ++i) {
    const Eigen::Vector3d force = end.wrenches[i].f_P_W - end.applied[i].f_P_W;
    const Eigen::Vector3d torque = end.wrenches[i].t_P_W - end.applied[i].t_P_W;
    defects[i] = to_seconds(H) * (force.dot(end.motions[i].v_WP) + torque.dot(end.motions[i].w_WP));
  }
  return defects;
}

bool keeps_its_motion(SimTime H, const MotionSet& begin, const MotionSet& end,
                      const std::vector<PortInfo>& ports) {
  constexpr double kStill = 1e-9;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const double change_m_per_s = (end[i].v_WP - begin[i].v_WP).norm() +
                                  ports[i].length_m * (end[i].w_WP - begin[i].w_WP).norm();
    const double size_m = end[i].p_WP.norm() + ports[i].length_m;
    // Written so that a change that is no number is none of round-off.
    if (!(to_seconds(H) * change_m_per_s <= kStill * size_m)) return false;
  }
  return true;
}

DivergenceMonitor::DivergenceMonitor(double growth, std::vector<PortInfo> ports)
    : growth_(growth), ports_(std::move(ports)) {}

std::optional<Divergence> DivergenceMonitor::check(SimTime H, const MacroStepEnd& end) {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if (!all_finite(WrenchSet{end.wrenches[i]}) || !all_finite(MotionSet{end.motions[i]})) {
      return Divergence{
          .text = fmt::format("port '{}' carries a value that is not finite", ports_[i].name)};
    }
  }
  const double residual_N =
      std::max(end.residual_N, std::exchange(last_residual_N_, end.residual_N));
  const MotionSet last_motions = std::exchange(last_motions_, end.motions);
  const bool still = last_motions.empty() || keeps_its_motion(H, last_motions, end.motions, ports_);
  if (still || residual_N <= 0.5 * wrench_norm_N(end.of_bodies(), ports_)) {
    streak_ = 0;
    return std::nullopt;
  }
  const std::vector<double> defects = energy_defects_J(H, end);
  double sum_J = 0.0;
  for (double defect : defects) sum_J += std::abs(defect);
  // Of the first two: the first one alone may be small by chance.
  if (streak_ == 0) {
    streak_first_defect_J_ = 0.0;
    streak_first_residual_N_ = residual_N;
  }
  if (streak_++ < 2) streak_first_defect_J_ = std::max(streak_first_defect_J_, sum_J);
  if (streak_ < kShortestStreak || sum_J <= growth_ * streak_first_defect_J_) return std::nullopt;

  const auto worst = std::max_element(defects.begin(), defects.end(),
                                      [](double a, double b) { return std::abs(a) < std::abs(b); });
  const std::string& port = ports_[static_cast<std::size_t>(worst - defects.begin())].name;
  return Divergence{
      .text = fmt::format(
          "the interface energy defect grew from {:.3g} J to {:.3g} J per macro step within {} "
          "macro steps, limit {:g} times; ‖r‖ = {:.3g} N, most of it at port '{}'",
          streak_first_defect_J_, sum_J, streak_, growth_, end.residual_N, port),
      .growth_per_step =
          std::pow(residual_N / streak_first_residual_N_, 1.0 / static_cast<double>(streak_ - 1)),
      .defect_J = sum_J};
}

double ratio_of_growth(double growth_per_step, Prediction prediction) {
  const double z = growth_per_step;
  switch (prediction) {
    case Prediction::Hold:
      return z;
    case Prediction::Linear:
      return z * z / (2.0 * z + 1.0);
    case Prediction::Quadratic:
      return z * z * z / (3.0 * z * z + 3.0 * z + 1.0);
  }
  return z;
}

}  // namespace tandem
