#pragma once

#include <Eigen/Core>
#include <array>

#include "fem_process/matrix/block_matrix.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

using Matrix12d = Eigen::Matrix<double, 12, 12>;
using Vector12d = Eigen::Matrix<double, 12, 1>;

/// Geometry of one linear tetrahedron, the same for all formulations.
struct TetShape {
  Tet nodes{};
  Eigen::Matrix<double, 4, 3> gradients = Eigen::Matrix<double, 4, 3>::Zero();  ///< ∂N_i/∂X (1/m)
  double volume = 0.0;                                                          ///< m³
  std::array<int, 16> blocks{};  ///< position of block (i, j) at 4 i + j
};
[[nodiscard]] TetShape make_tet_shape(const TetMesh& mesh, const Tet& tet,
                                      const BlockPattern& pattern);

/// Strain-displacement matrix of a linear tet, rows as in elasticity().
[[nodiscard]] Eigen::Matrix<double, 6, 12> strain_matrix(
    const Eigen::Matrix<double, 4, 3>& gradients);

/// The three edges from corner 0 as columns, out of positions or displacements of all nodes (m).
/// Taking differences keeps round-off independent of the distance from the world origin.
[[nodiscard]] Eigen::Matrix3d edges_of(const Tet& nodes, const Eigen::VectorXd& x);

/// Adds a symmetric element matrix into the pattern, both triangles.
void add_element_matrix(const TetShape& shape, const Matrix12d& K_e, BlockValues& K);

}  // namespace tandem::fem
