#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "fem_process/kernels/simd.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Where the 3×3 blocks of a symmetric node-by-node matrix stand: rows of ascending columns (CSR),
/// both triangles. Fixed for the life of a model, so that assembly needs no search.
struct BlockPattern {
  std::vector<int> row_start{0};  ///< rows + 1 entries
  std::vector<int> column;
  [[nodiscard]] int rows() const { return static_cast<int>(row_start.size()) - 1; }
  [[nodiscard]] std::size_t blocks() const { return column.size(); }
  /// Position of block (i, j), which must exist.
  [[nodiscard]] int find(int i, int j) const;
};

/// Values of the blocks of a pattern, 9 per block, row-major.
using BlockValues = std::vector<double>;

[[nodiscard]] inline Eigen::Map<Block> block(BlockValues& values, int b) {
  return Eigen::Map<Block>(values.data() + 9 * static_cast<std::ptrdiff_t>(b));
}
[[nodiscard]] inline Eigen::Map<const Block> block(const BlockValues& values, int b) {
  return Eigen::Map<const Block>(values.data() + 9 * static_cast<std::ptrdiff_t>(b));
}

/// Pattern of a mesh: nodes i and j share a block when they share a tet.
[[nodiscard]] BlockPattern pattern_of(const TetMesh& mesh);

/// The part of a pattern between kept nodes, renumbered in their order.
struct SubPattern {
  BlockPattern pattern;
  std::vector<int> source;  ///< block of the whole pattern for each block of the part
};
[[nodiscard]] SubPattern sub_pattern(const BlockPattern& whole, const std::vector<int>& kept);

/// The part of a product y = A x that is wanted: y is used at `rows` alone (elsewhere it is zero).
/// Nodes in ascending order; null: all.
struct ProductPart {
  const std::vector<int>* rows = nullptr;
};

/// y = A x with 3 rows per node. The sums run in column order: the same bits every time, for any
/// number of threads (null: the caller alone).
[[nodiscard]] Eigen::VectorXd multiply(const BlockPattern& pattern, const BlockValues& values,
                                       const Eigen::VectorXd& x, ProductPart part = {},
                                       ThreadTeam* team = nullptr);

/// Rows [begin, end) of the same product.
void multiply_rows(const BlockPattern& pattern, const BlockValues& values, const Padded* x,
                   Padded* y, std::size_t begin, std::size_t end);

/// Eight vectors side by side, one a row: column 3 i + k holds component k at node i of all.
using EightVectors = Eigen::Matrix<double, 8, Eigen::Dynamic>;

/// Y = A X for eight vectors at once.
void multiply_eight(const BlockPattern& pattern, const BlockValues& values, const EightVectors& X,
                    EightVectors& Y, ThreadTeam& team);

/// A X, one vector a column, eight of them at once; A may be unsymmetric.
[[nodiscard]] Eigen::MatrixXd multiply_columns(const BlockPattern& pattern,
                                               const BlockValues& values, const Eigen::MatrixXd& X,
                                               ThreadTeam& team);

/// y = (S ⊗ I₃) x: one number per block, as in a mass matrix.
[[nodiscard]] Eigen::VectorXd multiply_scalar(const BlockPattern& pattern,
                                              const std::vector<double>& values,
                                              const Eigen::VectorXd& x, ProductPart part = {});

}  // namespace tandem::fem
