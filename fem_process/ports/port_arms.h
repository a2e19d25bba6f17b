#pragma once

#include <Eigen/Core>
#include <vector>

namespace tandem::fem {

/// Port nodes' arms in port axes: r_i = R_WP(0)ᵀ (X_i − p_WP(0)), per port and node (m).
using PortArms = std::vector<std::vector<Eigen::Vector3d>>;

}  // namespace tandem::fem
