#pragma once

#include "fem_process/linear_solver.h"

namespace tandem::fem {

/// Conjugate gradients with the 3×3 diagonal blocks as preconditioner [Saad 2003, algorithm 9.1].
/// solve() corrects a guess, so a residual made with the previous velocities is the warm start of
/// [Marinkovic & Zehn 2012].
class PcgSolver final : public LinearSolver {
 public:
  PcgSolver(const SolverParams& params, const BlockPattern& pattern);

  SolveReport factorize(const BlockValues& A) override;
  SolveReport solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) override;

 private:
  SolveReport solve_column(Eigen::VectorXd& r, double b_norm) const;
  [[nodiscard]] Eigen::VectorXd precondition(const Eigen::VectorXd& r) const;

  SolverParams params_;
  const BlockPattern& pattern_;
  BlockValues A_;
  BlockValues inverse_diagonal_;
};

}  // namespace tandem::fem
