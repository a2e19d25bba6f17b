#pragma once

#include <Eigen/Core>
#include <optional>

#include "fem_process/mesh/mesh.h"
#include "protocol/contract/port.h"
#include "protocol/scenario/law.h"

namespace tandem::fem {

/// A node set that moves rigidly as a law of time says:
///   p_WP = about + s(t) translation,  R_WP = exp(s(t) [rotation]×),  v_WP, w_WP with ds/dt.
struct SetMotion {
  SetName set;
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> about_m;  ///< left out: the mean of the nodes
  Law law;                                 ///< s(t); 0 at t = 0
};

/// Origin of the set's frame at t = 0 (m).
[[nodiscard]] Eigen::Vector3d origin_of(const SetMotion& motion, const TetMesh& mesh);

/// The motion at time t of the frame that starts at `origin`. ds/dt is the central difference over
/// `step_s`/500 on both sides: exact for ramps and tables off their corners.
[[nodiscard]] Motion motion_at(const SetMotion& motion, const Eigen::Vector3d& origin, double t_s,
                               double step_s);

}  // namespace tandem::fem
