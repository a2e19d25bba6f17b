#include "fem_process/node_rotations.h"

#include <utility>

#include "fem_process/polar.h"
#include "fem_process/tet4.h"

namespace tandem::fem {

NodeRotations::NodeRotations(const TetMesh& mesh, const BlockPattern& pattern,
                             std::vector<int> nodes)
    : pattern_(pattern), nodes_(std::move(nodes)), G_(pattern.blocks(), Eigen::Vector3d::Zero()) {
  std::vector<double> volume(mesh.X.size(), 0.0);
  for (const Tet& tet : mesh.tets) {
    const TetShape shape = make_tet_shape(mesh, tet, pattern);
    for (std::size_t i = 0; i < 4; ++i) {
      volume[static_cast<std::size_t>(tet[i])] += shape.volume;
      for (std::size_t j = 0; j < 4; ++j) {
        G_[static_cast<std::size_t>(shape.blocks[4 * i + j])] +=
            shape.volume * shape.gradients.row(static_cast<Eigen::Index>(j)).transpose();
      }
    }
  }
  for (std::size_t i = 0; i < volume.size(); ++i) {
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      G_[static_cast<std::size_t>(b)] /= volume[i];
    }
  }
}

std::vector<Eigen::Matrix3d> NodeRotations::at(const Eigen::VectorXd& x) const {
  std::vector<Eigen::Matrix3d> rotations;
  rotations.reserve(nodes_.size());
  for (int node : nodes_) {
    const auto row = static_cast<std::size_t>(node);
    const Eigen::Vector3d x_i = x.segment<3>(3 * node);
    Eigen::Matrix3d F = Eigen::Matrix3d::Zero();
    for (int b = pattern_.row_start[row]; b < pattern_.row_start[row + 1]; ++b) {
      const auto at = static_cast<std::size_t>(b);
      F += (x.segment<3>(3 * pattern_.column[at]) - x_i) * G_[at].transpose();
    }
    rotations.push_back(polar_rotation(F).R);
  }
  return rotations;
}

}  // namespace tandem::fem
