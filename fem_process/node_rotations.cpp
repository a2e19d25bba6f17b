#include "fem_process/node_rotations.h"

#include <algorithm>
#include <utility>

#include "fem_process/polar_lanes.h"
#include "fem_process/tet4.h"

namespace tandem::fem {
namespace {

/// R = polar(F) of four matrices.
TANDEM_INLINE void turn_body(const double (&F)[9][kLanes], double (&R)[9][kLanes]) {
  LaneMatrix in;
  LaneMatrix out;
  for (int k = 0; k < 9; ++k) load(in.at[k], F[k]);
  polar_lanes(in, out);
  for (int k = 0; k < 9; ++k) std::memcpy(R[k], &out.at[k], sizeof R[k]);
}

TANDEM_VECTOR_FUNCTION(turn, turn_body, (const double (&F)[9][kLanes], double (&R)[9][kLanes]),
                       (F, R))

}  // namespace

NodeRotations::NodeRotations(const TetMesh& mesh, const BlockPattern& pattern,
                             std::vector<int> nodes)
    : pattern_(pattern), nodes_(std::move(nodes)), G_(pattern.blocks(), Eigen::Vector3d::Zero()) {
  std::vector<double> volume(mesh.X.size(), 0.0);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const Tet& corners = mesh.tets[e];
    const TetShape shape = make_tet_shape(mesh, corners, pattern);
    for (int i : mesh.element(e)) {
      volume[static_cast<std::size_t>(i)] += shape.volume;
      for (std::size_t j = 0; j < 4; ++j) {
        G_[static_cast<std::size_t>(pattern.find(i, corners[j]))] +=
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
  std::vector<Eigen::Matrix3d> rotations(nodes_.size());
  for (std::size_t first = 0; first < nodes_.size(); first += kLanes) {
    const std::size_t count = std::min<std::size_t>(kLanes, nodes_.size() - first);
    double F[9][kLanes];
    for (std::size_t n = 0; n < kLanes; ++n) {
      const Block lane = gradient(nodes_[first + std::min(n, count - 1)], x);
      for (int k = 0; k < 9; ++k) F[k][n] = lane(k / 3, k % 3);
    }
    double R[9][kLanes];
    turn(F, R);
    for (std::size_t n = 0; n < count; ++n) {
      for (int k = 0; k < 9; ++k) rotations[first + n](k / 3, k % 3) = R[k][n];
    }
  }
  return rotations;
}

Block NodeRotations::gradient(int node, const Eigen::VectorXd& x) const {
  const auto row = static_cast<std::size_t>(node);
  const Eigen::Vector3d x_i = x.segment<3>(3 * node);
  Block F = Block::Zero();
  for (int b = pattern_.row_start[row]; b < pattern_.row_start[row + 1]; ++b) {
    const auto at = static_cast<std::size_t>(b);
    F.noalias() += (x.segment<3>(3 * pattern_.column[at]) - x_i) * G_[at].transpose();
  }
  return F;
}

}  // namespace tandem::fem
