#include "fem_process/turning/elastic_turn.h"

#include <Eigen/LU>
#include <algorithm>
#include <set>
#include <vector>

namespace tandem::fem {
namespace {

/// ∂N_i/∂X of the corners (1/m).
Eigen::Matrix<double, 4, 3> gradients_of(const TetMesh& mesh, const Tet& tet) {
  const auto X = [&](std::size_t i) { return mesh.X[static_cast<std::size_t>(tet[i])]; };
  Eigen::Matrix3d edges;
  edges << X(1) - X(0), X(2) - X(0), X(3) - X(0);
  Eigen::Matrix<double, 4, 3> gradients;
  gradients.bottomRows<3>() = edges.inverse();
  gradients.row(0) = -gradients.bottomRows<3>().colwise().sum();
  return gradients;
}

Eigen::Vector3d turn_of(const Tet& tet, const Eigen::Matrix<double, 4, 3>& gradients,
                        const Eigen::MatrixXd& shapes, Eigen::Index shape) {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d u =
        shapes.block<1, 3>(tet[static_cast<std::size_t>(i)], 3 * shape).transpose();
    turn += 0.5 * Eigen::Vector3d(gradients.row(i)).cross(u);
  }
  return turn;
}

}  // namespace

ElasticTurn::ElasticTurn(const TetMesh& mesh, const Eigen::MatrixXd& shapes) {
  const Eigen::Index count = shapes.cols() / 3;
  std::vector<Eigen::Matrix<double, 4, 3>> gradients;
  gradients.reserve(mesh.tets.size());
  for (const Tet& tet : mesh.tets) gradients.push_back(gradients_of(mesh, tet));
  std::set<std::size_t> followed;
  for (Eigen::Index c = 0; c < count; ++c) {
    std::size_t most = 0;
    double largest = -1.0;
    for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
      const double turn = turn_of(mesh.tets[e], gradients[e], shapes, c).norm();
      if (turn > largest) largest = turn, most = e;
    }
    followed.insert(most);
  }
  turns_.resize(3 * static_cast<Eigen::Index>(followed.size()), count);
  Eigen::Index row = 0;
  for (const std::size_t e : followed) {
    for (Eigen::Index c = 0; c < count; ++c) {
      turns_.block<3, 1>(row, c) = turn_of(mesh.tets[e], gradients[e], shapes, c);
    }
    row += 3;
  }
}

double ElasticTurn::largest_rad(const Eigen::VectorXd& z) const {
  const Eigen::VectorXd turns = turns_ * z;
  double largest = 0.0;
  for (Eigen::Index row = 0; row < turns.size(); row += 3) {
    largest = std::max(largest, turns.segment<3>(row).norm());
  }
  return largest;
}

double largest_turn_rad(const TetMesh& mesh, const Eigen::VectorXd& x) {
  double largest = 0.0;
  for (const Tet& tet : mesh.tets) {
    const Eigen::Matrix<double, 4, 3> gradients = gradients_of(mesh, tet);
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
    for (int i = 0; i < 4; ++i) {
      const auto node = static_cast<std::size_t>(tet[static_cast<std::size_t>(i)]);
      const Eigen::Vector3d u = x.segment<3>(3 * static_cast<Eigen::Index>(node)) - mesh.X[node];
      turn += 0.5 * Eigen::Vector3d(gradients.row(i)).cross(u);
    }
    largest = std::max(largest, turn.norm());
  }
  return largest;
}

}  // namespace tandem::fem
