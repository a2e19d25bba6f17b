#include "protocol/contract/port.h"

#include <cmath>

#include "protocol/contract/error.h"

namespace tandem {

Eigen::VectorXd stack(const WrenchSet& wrenches) {
  Eigen::VectorXd stacked(6 * static_cast<Eigen::Index>(wrenches.size()));
  Eigen::Index row = 0;
  for (const Wrench& wrench : wrenches) {
    stacked.segment<3>(row) = wrench.f_P_W;
    stacked.segment<3>(row + 3) = wrench.t_P_W;
    row += 6;
  }
  return stacked;
}

WrenchSet unstack_wrenches(const Eigen::VectorXd& stacked) {
  require(stacked.size() % 6 == 0, "stacked wrenches must have 6 rows per port");
  WrenchSet wrenches(static_cast<std::size_t>(stacked.size() / 6));
  Eigen::Index row = 0;
  for (Wrench& wrench : wrenches) {
    wrench.f_P_W = stacked.segment<3>(row);
    wrench.t_P_W = stacked.segment<3>(row + 3);
    row += 6;
  }
  return wrenches;
}

Eigen::VectorXd difference(const MotionSet& a, const MotionSet& b) {
  require(a.size() == b.size(), "motions of different port tables cannot be compared");
  Eigen::VectorXd result(12 * static_cast<Eigen::Index>(a.size()));
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto row = 12 * static_cast<Eigen::Index>(i);
    // R_b = exp(θ×) R_a. The vector part of q_b q_a⁻¹ keeps full precision for tiny angles, where
    // the scalar part does not; q and −q are the same rotation.
    Eigen::Quaterniond dq = b[i].q_WP * a[i].q_WP.conjugate();
    if (dq.w() < 0.0) dq.coeffs() = -dq.coeffs();
    const double half_sine = dq.vec().norm();
    const double scale = half_sine < 1e-8 ? 2.0 : 2.0 * std::atan2(half_sine, dq.w()) / half_sine;
    result.segment<3>(row) = b[i].p_WP - a[i].p_WP;
    result.segment<3>(row + 3) = scale * dq.vec();
    result.segment<3>(row + 6) = b[i].v_WP - a[i].v_WP;
    result.segment<3>(row + 9) = b[i].w_WP - a[i].w_WP;
  }
  return result;
}

MotionSet displaced(const MotionSet& a, const Eigen::VectorXd& xi) {
  require(xi.size() == 12 * static_cast<Eigen::Index>(a.size()),
          "a displacement of motions must have 12 rows per port");
  MotionSet b = a;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto row = 12 * static_cast<Eigen::Index>(i);
    const Eigen::Vector3d theta = xi.segment<3>(row + 3);
    const double angle = theta.norm();
    // sin(θ/2)/θ of a tiny angle by its series, which does not divide by zero.
    const double scale = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
    Eigen::Quaterniond dq;
    dq.w() = std::cos(0.5 * angle);
    dq.vec() = scale * theta;
    b[i].p_WP += xi.segment<3>(row);
    b[i].q_WP = (dq * a[i].q_WP).normalized();
    b[i].v_WP += xi.segment<3>(row + 6);
    b[i].w_WP += xi.segment<3>(row + 9);
  }
  return b;
}

double wrench_norm_N(const WrenchSet& wrenches, const std::vector<PortInfo>& ports) {
  require(wrenches.size() == ports.size(), "one wrench per port is needed");
  double sum = 0.0;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    sum += wrenches[i].f_P_W.squaredNorm() +
           wrenches[i].t_P_W.squaredNorm() / (ports[i].length_m * ports[i].length_m);
  }
  return std::sqrt(sum);
}

double motion_norm_m_per_s(const Eigen::VectorXd& xi, const std::vector<PortInfo>& ports,
                           double H_s) {
  require(xi.size() == 12 * static_cast<Eigen::Index>(ports.size()),
          "one motion per port is needed");
  double sum = 0.0;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const auto row = 12 * static_cast<Eigen::Index>(i);
    const double length = ports[i].length_m;
    sum += (xi.segment<3>(row).squaredNorm() +
            length * length * xi.segment<3>(row + 3).squaredNorm()) /
               (H_s * H_s) +
           xi.segment<3>(row + 6).squaredNorm() +
           length * length * xi.segment<3>(row + 9).squaredNorm();
  }
  return std::sqrt(sum);
}

double interface_power_W(const WrenchSet& wrenches, const MotionSet& motions) {
  double power = 0.0;
  for (std::size_t i = 0; i < wrenches.size(); ++i) {
    power += wrenches[i].f_P_W.dot(motions[i].v_WP) + wrenches[i].t_P_W.dot(motions[i].w_WP);
  }
  return power;
}

bool all_finite(const WrenchSet& wrenches) {
  for (const Wrench& wrench : wrenches) {
    if (!wrench.f_P_W.allFinite() || !wrench.t_P_W.allFinite()) return false;
  }
  return true;
}

bool all_finite(const MotionSet& motions) {
  for (const Motion& motion : motions) {
    if (!motion.p_WP.allFinite() || !motion.q_WP.coeffs().allFinite() || !motion.v_WP.allFinite() ||
        !motion.w_WP.allFinite()) {
      return false;
    }
  }
  return true;
}

}  // namespace tandem
