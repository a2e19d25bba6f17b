#pragma once

#include <Eigen/Core>

#include "fem_process/ports/loose_ports.h"
#include "tests/support/fem_support.h"

namespace tandem::fem::testing {

inline scenario::Attachment averaging(
    scenario::NodeWeights weights = scenario::NodeWeights::Uniform) {
  return {.kind = scenario::AttachmentKind::Averaging, .weights = weights};
}

inline scenario::Attachment bushing(double translation_N_per_m, double rotation_Nm_per_rad) {
  scenario::Attachment attachment{.kind = scenario::AttachmentKind::Bushing};
  attachment.bushing.stiffness.diagonal().head<3>().setConstant(translation_N_per_m);
  attachment.bushing.stiffness.diagonal().tail<3>().setConstant(rotation_Nm_per_rad);
  return attachment;
}

/// Stiffness and damping with all couplings, in axes of its own: A Aᵀ is positive semidefinite.
inline scenario::Attachment full_bushing() {
  scenario::Attachment attachment = bushing(3e4, 40.0);
  scenario::Matrix6 A;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) A(i, j) = std::sin(1.0 + 3.0 * i + 7.0 * j);
  }
  Eigen::Matrix<double, 6, 1> size;
  size << 100.0, 80.0, 120.0, 3.0, 4.0, 5.0;
  const scenario::Matrix6 root = size.asDiagonal() * A;
  attachment.bushing.stiffness += root * root.transpose();
  attachment.bushing.damping = 2e-3 * root * root.transpose();
  attachment.bushing.q_PB = rotation({0.4, -0.7, 0.3});
  return attachment;
}

/// The loose ports of a model whose port frames stood at `motions` at t = 0.
inline LoosePorts loose_ports_of(const Model& model, const MotionSet& motions) {
  PortArms arms;
  for (std::size_t p = 0; p < model.ports.size(); ++p) {
    std::vector<Eigen::Vector3d>& port = arms.emplace_back();
    for (int node : model.ports[p].nodes) {
      port.push_back(motions[p].q_WP.conjugate() *
                     (model.mesh.X[static_cast<std::size_t>(node)] - motions[p].p_WP));
    }
  }
  return LoosePorts(model, arms);
}

}  // namespace tandem::fem::testing
