#include "fem_process/ports/set_motion.h"

namespace tandem::fem {

Eigen::Vector3d origin_of(const SetMotion& motion, const TetMesh& mesh) {
  if (motion.about_m) return *motion.about_m;
  const NodeSet& set = find_set(mesh, motion.set);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int node : set.nodes) sum += mesh.X[static_cast<std::size_t>(node)];
  return sum / static_cast<double>(set.nodes.size());
}

Motion motion_at(const SetMotion& motion, const Eigen::Vector3d& origin, double t_s,
                 double step_s) {
  const double s = motion.law(t_s);
  const double delta = step_s / 500.0;
  const double rate = (motion.law(t_s + delta) - motion.law(t_s - delta)) / (2.0 * delta);
  Motion m;
  m.p_WP = origin + s * motion.translation_m;
  m.v_WP = rate * motion.translation_m;
  m.w_WP = rate * motion.rotation_rad;
  if (const double angle = motion.rotation_rad.norm(); angle > 0.0) {
    m.q_WP = Eigen::Quaterniond(Eigen::AngleAxisd(s * angle, motion.rotation_rad / angle));
  }
  return m;
}

}  // namespace tandem::fem
