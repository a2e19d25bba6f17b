#pragma once

#include <cmath>
#include <vector>

#include "fem_process/mesh/mesh.h"
#include "tests/support/fem_support.h"

namespace tandem::fem::testing {

/// Nodes on no face of the bounding box.
inline std::vector<int> inner_nodes(const TetMesh& mesh) {
  Eigen::Vector3d low = mesh.X.front();
  Eigen::Vector3d high = low;
  for (const Eigen::Vector3d& X : mesh.X) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
  std::vector<int> inner;
  for (int i = 0; i < mesh.nodes(); ++i) {
    const Eigen::Vector3d& X = mesh.X[static_cast<std::size_t>(i)];
    if ((X - low).minCoeff() > 1e-9 && (high - X).minCoeff() > 1e-9) inner.push_back(i);
  }
  return inner;
}

/// The bar with its inner mid nodes moved, so that its elements are curved but for their faces on
/// the outside.
inline TetMesh curved_bar() {
  TetMesh mesh = read_mesh({.file = data_file("bar.msh"), .order = 2});
  const TetMesh straight = read_mesh({.file = data_file("bar.msh")});
  for (int i : inner_nodes(mesh)) {
    if (i < straight.nodes()) continue;
    const double s = i;
    mesh.X[static_cast<std::size_t>(i)] +=
        1e-3 * Eigen::Vector3d(std::sin(s), std::cos(2.0 * s), std::sin(3.0 * s));
  }
  return mesh;
}

}  // namespace tandem::fem::testing
