#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "fem_process/block_matrix.h"
#include "fem_process/linear_solver.h"

namespace tandem::fem {

/// A supernodal Cholesky factor P A Pᵀ = L Lᵀ. Supernode s has the columns first_column[s] …
/// first_column[s + 1] − 1; their common rows are row[row_start[s] …], the columns themselves
/// first. Values by columns, as many rows apart as the supernode has.
struct SupernodalFactor {
  std::vector<int> permutation;  ///< row of A for each row of P A Pᵀ
  std::vector<int> first_column;
  std::vector<int> row_start;
  std::vector<int> row;
  std::vector<int> value_start;
  std::vector<double> value;
  [[nodiscard]] int supernodes() const { return static_cast<int>(first_column.size()) - 1; }
};

/// Cholesky factor of a step matrix at the reference positions, as a preconditioner: made once,
/// held in single precision, since a preconditioner need not be exact. Per supernode one dense
/// panel
///   [L₁₁⁻¹; −L₂₁ L₁₁⁻¹]
/// serves both triangular solves as a product [Alvarado & Schreiber 1993; Courtecuisse et al.
/// 2010]. The same bits on every processor: vectors of fixed length, no fused multiply-add.
class RestFactor {
 public:
  /// Throws a Usage error when A is not positive definite.
  RestFactor(const BlockPattern& pattern, const BlockValues& A);

  /// Working memory of solve(): one per caller.
  struct Scratch {
    std::vector<float> y;
    std::vector<float> rows;
  };
  /// z ≈ A⁻¹ r to single precision, relative to the largest entries of r.
  void solve(const Eigen::VectorXd& r, Eigen::VectorXd& z, Scratch& scratch) const;

 private:
  struct Panel {
    int first_column = 0;
    int columns = 0;
    int rows = 0;           ///< columns included
    int padded = 0;         ///< rows, rounded up to whole vectors: distance of columns
    int row_start = 0;      ///< in row_, of the rows below the columns
    std::size_t value = 0;  ///< in value_
  };
  void add_panel(const SupernodalFactor& factor, int s);
  void run(Scratch& scratch) const;

  std::vector<int> permutation_;
  std::vector<int> row_;
  std::vector<Panel> panels_;
  std::vector<float> value_;
  int most_rows_ = 0;
};

}  // namespace tandem::fem
