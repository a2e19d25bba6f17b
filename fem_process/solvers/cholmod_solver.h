#pragma once

#include <memory>
#include <vector>

#include "fem_process/solvers/linear_solver.h"

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

/// Order of elimination of a pattern's nodes by nested dissection (CHOLMOD with METIS): little
/// fill, and an elimination tree with branches of like size. Minimum degree where CHOLMOD was built
/// without METIS. Throws a Usage error when neither works.
[[nodiscard]] std::vector<int> fill_reducing_order(const BlockPattern& pattern);

/// Supernodal sparse Cholesky factorisation by CHOLMOD [Chen, Davis, Hager, Rajamanickam 2008]; the
/// symbolic analysis is made once, in the constructor, in the order of fill_reducing_order(). One
/// thread whatever the user's environment
/// says: CHOLMOD's own OpenMP regions (always 4 threads in Debian's build) are serialised around
/// each call and OpenBLAS is told to use one thread, for speed on few cores and for equal bits.
class CholmodSolver final : public LinearSolver {
 public:
  explicit CholmodSolver(const BlockPattern& pattern);
  ~CholmodSolver() override;

  using LinearSolver::factorize;
  SolveReport factorize(const BlockValues& A, const std::vector<NodeRotation>& rotations) override;
  SolveReport solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) override;

  /// A copy of the last factor.
  [[nodiscard]] SupernodalFactor factor() const;

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace tandem::fem
