#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/body/model.h"

namespace tandem::fem {

/// A part of the boundary that moves rigidly: a port's nodes, or all fixed nodes.
struct RigidPart {
  std::vector<int> nodes;
  Eigen::Vector3d p0 = Eigen::Vector3d::Zero();  ///< reference point its rotation is about (m)
};

/// Static shapes of the body, one column per small displacement of a rigid part, the other parts
/// held and the interior free of force:
///   K_II Ψ_I = −K_IB Ψ_B,   Ψ_B = [e_x e_y e_z | e_x × r … ],   r = X − p0.
/// 6 columns per part, all nodes. Throws a Usage error when the parts do not hold the body, so that
/// K_II is singular.
[[nodiscard]] Eigen::MatrixXd constraint_modes(const Model& model,
                                               const std::vector<RigidPart>& parts);

/// Vibration of the body with its boundary held: K φ = ω² M φ, φᵀ M φ = 1, φ = 0 at prescribed
/// nodes, ascending. All modes up to the limit when there is one, else the first `modes`.
struct BoundaryModes {
  Eigen::VectorXd angular_frequencies;  ///< rad/s
  Eigen::MatrixXd shapes;               ///< all nodes (1/√kg)
};
[[nodiscard]] BoundaryModes fixed_boundary_modes(const Model& model,
                                                 const CraigBamptonParams& params);

}  // namespace tandem::fem
