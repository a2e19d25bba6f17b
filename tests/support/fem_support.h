#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <string>

#include "fem_process/sides/flexible_body.h"

namespace tandem::fem::testing {

inline std::filesystem::path data_file(const std::string& name) {
  return std::filesystem::path(TANDEM_SOURCE_DIR) / "tests/data/fem" / name;
}

inline Eigen::Quaterniond rotation(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle == 0.0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation_vector / angle));
}

/// The free bar 0.5 m × 0.05 m × 0.05 m along x (369 tets), its end faces as ports.
inline Params bar_with_two_ports() {
  Params params;
  params.mesh.file = data_file("bar.msh");
  params.material = {.young_Pa = 5e6, .poisson = 0.3, .density_kg_per_m3 = 1000.0};
  params.micro_step = SimTime(1'000'000);
  params.ports = {{"left", {"left"}, Eigen::Vector3d(-0.28, 0, 0)},
                  {"right", {"right"}, Eigen::Vector3d(0.28, 0, 0)}};
  return params;
}

/// Port motions of a rotating, translating and stretching pair at time t, smooth in t.
inline MotionSet pair_motion(double t) {
  MotionSet motions(2);
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? -1.0 : 1.0;
    const Eigen::Vector3d w(0.3, -0.4, 2.0 + 0.5 * sign);
    Motion& m = motions[static_cast<std::size_t>(side)];
    m.q_WP = rotation(w * t);
    m.w_WP = w;
    m.p_WP = Eigen::Vector3d(sign * 0.28, 0, 0) + t * Eigen::Vector3d(0.1, sign * 0.7, -0.2) +
             t * t * Eigen::Vector3d(sign * 0.5, 1.0, 0.3);
    m.v_WP =
        Eigen::Vector3d(0.1, sign * 0.7, -0.2) + 2.0 * t * Eigen::Vector3d(sign * 0.5, 1.0, 0.3);
  }
  return motions;
}

inline StepRequest<MotionSet> request(const MotionSet& begin, const MotionSet& end, SimTime step,
                                      bool linearize = false) {
  return {.step = step, .input = {begin, end}, .linearize = linearize};
}

/// P = Σ_ij M_ij v_j (kg m/s).
inline Eigen::Vector3d linear_momentum(const FlexibleBody& body) {
  const Model& model = body.model();
  const Eigen::VectorXd p = multiply_scalar(model.pattern(), model.mass, body.state().v);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < p.size(); i += 3) sum += p.segment<3>(i);
  return sum;
}

}  // namespace tandem::fem::testing
