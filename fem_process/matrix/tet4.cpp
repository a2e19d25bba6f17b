#include "fem_process/matrix/tet4.h"

#include <Eigen/Dense>

namespace tandem::fem {

TetShape make_tet_shape(const TetMesh& mesh, const Tet& tet, const BlockPattern& pattern) {
  TetShape shape;
  shape.nodes = tet;
  shape.volume = signed_volume(mesh, tet);
  Eigen::Matrix3d edges;
  for (int k = 0; k < 3; ++k) {
    edges.col(k) = mesh.X[static_cast<std::size_t>(tet[static_cast<std::size_t>(k) + 1])] -
                   mesh.X[static_cast<std::size_t>(tet[0])];
  }
  // Rows 1..3 are the inverse of the edge matrix.
  shape.gradients.bottomRows<3>() = edges.inverse();
  shape.gradients.row(0) = -shape.gradients.bottomRows<3>().colwise().sum();
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) shape.blocks[4 * i + j] = pattern.find(tet[i], tet[j]);
  }
  return shape;
}

Eigen::Matrix<double, 6, 12> strain_matrix(const Eigen::Matrix<double, 4, 3>& gradients) {
  Eigen::Matrix<double, 6, 12> B = Eigen::Matrix<double, 6, 12>::Zero();
  for (int i = 0; i < 4; ++i) {
    const double x = gradients(i, 0);
    const double y = gradients(i, 1);
    const double z = gradients(i, 2);
    B.block<6, 3>(0, 3 * i) << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, 0, z, y, z, 0, x;
  }
  return B;
}

Eigen::Matrix3d edges_of(const Tet& nodes, const Eigen::VectorXd& x) {
  Eigen::Matrix3d edges;
  for (int k = 0; k < 3; ++k) {
    edges.col(k) =
        x.segment<3>(3 * nodes[static_cast<std::size_t>(k) + 1]) - x.segment<3>(3 * nodes[0]);
  }
  return edges;
}

void add_element_matrix(const TetShape& shape, const Matrix12d& K_e, BlockValues& K) {
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      block(K, shape.blocks[static_cast<std::size_t>(4 * i + j)]) += K_e.block<3, 3>(3 * i, 3 * j);
    }
  }
}

}  // namespace tandem::fem
