#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "fem_process/matrix/block_matrix.h"

namespace tandem::fem {

/// Mean distance of nodes that share a block (m).
[[nodiscard]] double mean_edge(const BlockPattern& pattern,
                               const std::vector<Eigen::Vector3d>& positions);

/// An order of positions in which near ones follow each other: by the boxes of a cube's division
/// into 1024³ in the order of Morton [1966], in one box as they are given.
[[nodiscard]] std::vector<int> near_order(const std::vector<Eigen::Vector3d>& positions);

/// A regular lattice over a body, as the coarse space of multigrid: displacements are those of the
/// lattice's nodes, trilinear in its cells. It holds every linear displacement, hence rigid motions
/// and constant strains, whatever the mesh.
class Lattice {
 public:
  /// Over these positions (m), with cells as near to `spacing` (m) as a whole number of them
  /// allows in each direction. Lattice nodes that no position hangs on are left out.
  Lattice(const std::vector<Eigen::Vector3d>& positions, double spacing);

  /// What a position takes from its cell's corners: Σ weight = 1. A corner of no weight is listed
  /// with the first one's number.
  struct Corners {
    std::array<int, 8> node{};
    std::array<double, 8> weight{};
  };
  [[nodiscard]] const std::vector<Corners>& corners() const { return corners_; }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& positions() const { return positions_; }

  /// Pᵀ A P with P = the corners' weights, one for the three directions; the diagonal blocks times
  /// 1 + 1e-6: where few positions hang on many lattice nodes, columns of P depend on one another,
  /// and the matrix is to be definite all the same. The same bits every time.
  void project(const BlockPattern& pattern, const BlockValues& A, BlockPattern& coarse_pattern,
               BlockValues& coarse_A) const;

 private:
  std::vector<Corners> corners_;
  std::vector<Eigen::Vector3d> positions_;
};

}  // namespace tandem::fem
