#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/body/model.h"

namespace tandem::fem {

/// Nodes of a mesh that elements connect, and what holds them: ports, and the ground where nodes
/// are fixed. A body may consist of several parts, each of which turns in its own way.
struct BodyPart {
  static constexpr int kGround = -1;

  std::vector<int> nodes;    ///< ascending
  std::vector<int> holders;  ///< indices of ports, kGround; empty: the part is free in space
  /// How much every node (row, as in `nodes`) goes with every holder, ≥ 0 with row sums of 1:
  ///   φ_ik = (1/D_ik) / Σ_j (1/D_ij),
  /// D_ik the shortest way along edges of elements from node i to the nodes of holder k (m). So a
  /// holder's own nodes go with it alone, and between the ends of a rod φ is linear.
  Eigen::MatrixXd shares;
};

/// The parts of a body, in the order of their first nodes.
[[nodiscard]] std::vector<BodyPart> body_parts(const Model& model);

}  // namespace tandem::fem
