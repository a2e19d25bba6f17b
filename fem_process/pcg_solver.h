#pragma once

#include "fem_process/linear_solver.h"
#include "fem_process/rest_factor.h"

namespace tandem::fem {

/// Preconditioned conjugate gradients [Saad 2003, algorithm 9.1]. solve() corrects a guess, so a
/// residual made with the previous velocities is the warm start of [Marinkovic & Zehn 2012].
/// Deterministic; what it remembers between two solves is the matrix alone.
class PcgSolver final : public LinearSolver {
 public:
  /// `rest` may be null: then the preconditioner is BlockJacobi whatever `params` says.
  PcgSolver(const SolverParams& params, const BlockPattern& pattern, const RestFactor* rest);

  using LinearSolver::factorize;
  SolveReport factorize(const BlockValues& A,
                        const std::vector<Eigen::Matrix3d>& rotations) override;
  SolveReport solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) override;

 private:
  SolveReport invert_diagonal(const BlockValues& A);
  SolveReport solve_column(Eigen::VectorXd& r, double b_norm);
  /// z_ = P⁻¹ r.
  void precondition(const Eigen::VectorXd& r);

  SolverParams params_;
  const BlockPattern& pattern_;
  const RestFactor* rest_;
  BlockValues columns_;  ///< of A's blocks
  BlockValues inverse_diagonal_;
  std::vector<Eigen::Matrix3d> rotations_;
  RestFactor::Scratch scratch_;
  Eigen::VectorXd x_;
  Eigen::VectorXd z_;
  Eigen::VectorXd p_;
  Eigen::VectorXd Ap_;
  Eigen::VectorXd turned_;
};

}  // namespace tandem::fem
