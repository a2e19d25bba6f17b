#pragma once

#include <memory>

#include "fem_process/linear_solver.h"
#include "fem_process/rest_factor.h"

namespace tandem::fem {

/// Supernodal sparse Cholesky factorisation by CHOLMOD [Chen, Davis, Hager, Rajamanickam 2008]; the
/// symbolic analysis is made once, in the constructor. One thread whatever the user's environment
/// says: CHOLMOD's own OpenMP regions (always 4 threads in Debian's build) are serialised around
/// each call and OpenBLAS is told to use one thread, for speed on few cores and for equal bits.
class CholmodSolver final : public LinearSolver {
 public:
  explicit CholmodSolver(const BlockPattern& pattern);
  ~CholmodSolver() override;

  using LinearSolver::factorize;
  SolveReport factorize(const BlockValues& A,
                        const std::vector<Eigen::Matrix3d>& rotations) override;
  SolveReport solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) override;

  /// A copy of the last factor.
  [[nodiscard]] SupernodalFactor factor() const;

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace tandem::fem
