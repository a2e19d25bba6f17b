#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/kernels/simd.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/block_matrix.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// A rotation in single precision: its rows and its columns, three numbers and a zero each.
struct alignas(32) NodeRotation {
  float row[3][4];
  float column[3][4];
};

/// How far nodes have turned since the reference positions: the rotation of the polar decomposition
/// of the mean deformation gradient of the tets around a node (of second order: that of their
/// corners), weighted by volume,
///   F_i = Σ_e V_e F_e / Σ_e V_e = Σ_j (x_j − x_i) ⊗ G_ij,  G_ij = Σ_e V_e ∇N_j / Σ_e V_e.
/// In single precision: enough for a preconditioner.
class NodeRotations {
 public:
  /// Of these nodes; the pattern must outlive the object.
  NodeRotations(const TetMesh& mesh, const BlockPattern& pattern, std::vector<int> nodes);

  /// At positions x of all nodes (m), in the order of the nodes.
  void at(const Eigen::VectorXd& x, std::vector<NodeRotation>& rotations, ThreadTeam& team) const;

 private:
  const BlockPattern& pattern_;
  std::vector<int> nodes_;
  std::vector<Padded> G_;  ///< per block of the pattern (1/m)
};

}  // namespace tandem::fem
