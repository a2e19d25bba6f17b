#pragma once

#include <cstddef>
#include <vector>

#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/block_matrix.h"
#include "fem_process/solvers/rest_inverse.h"

namespace tandem::fem {

/// A symmetric block matrix A = D + L + Lᵀ (D the diagonal blocks) in single precision, with the
/// sweeps of Gauss and Seidel. Rows stand in the order of the sweeps: nodes go in tiles of
/// neighbours, tiles that share no block have the same colour and are swept side by side, colours
/// one after the other. The order depends on the matrix alone, hence the bits do not depend on the
/// threads.
///
/// A is scaled to a mean diagonal entry of 1 per node first. Forward sweep, cycle on the residual
/// and backward sweep give a symmetric positive definite operator (up to single precision) as long
/// as D is positive definite: its part without the cycle is (D + L)⁻ᵀ D (D + L)⁻¹.
class GaussSeidel {
 public:
  /// `near`: the nodes, neighbours one after the other as far as possible; see near_order().
  GaussSeidel(const BlockPattern& pattern, const BlockValues& A, const std::vector<int>& near);

  [[nodiscard]] std::size_t nodes() const { return node_.size(); }
  /// The matrix's node at each place of the sweeps' order.
  [[nodiscard]] const std::vector<int>& order() const { return node_; }
  /// √(mean diagonal entry of A) of the node at each place.
  [[nodiscard]] const std::vector<double>& root() const { return root_; }

  /// (D + L) x = r.
  void forward(const Padded4* r, Padded4* x, ThreadTeam& team) const;
  /// r − A x after forward(): −Lᵀ x.
  void residual(const Padded4* x, Padded4* left, ThreadTeam& team) const;
  /// x ← D⁻¹ (r − L x − Lᵀ x) from the last node to the first.
  void backward(const Padded4* r, Padded4* x, ThreadTeam& team) const;

  [[nodiscard]] std::size_t bytes() const;

  /// Blocks before the diagonal from `first`, behind it from `middle` to the next row's first.
  struct Row {
    int first = 0;
    int middle = 0;
  };

 private:
  void set_order(const BlockPattern& pattern, const std::vector<int>& near);
  void set_values(const BlockPattern& pattern, const BlockValues& A);
  void invert(const Eigen::Matrix3d& diagonal);

  std::vector<int> node_;
  std::vector<double> root_;
  std::vector<int> tile_start_;    ///< places; one more entry than tiles
  std::vector<int> colour_start_;  ///< tiles; one more entry than colours
  std::vector<Row> row_;
  std::vector<int> column_;
  std::vector<float> value_;               ///< columns of a block, one after the other
  std::vector<Padded4> inverse_diagonal_;  ///< columns of D⁻¹, three per place
};

}  // namespace tandem::fem
