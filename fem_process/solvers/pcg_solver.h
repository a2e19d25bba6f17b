#pragma once

#include "fem_process/solvers/linear_solver.h"
#include "fem_process/solvers/pcg_columns.h"
#include "fem_process/solvers/rest_inverse.h"

namespace tandem::fem {

/// Preconditioned conjugate gradients [Saad 2003, algorithm 9.1]. solve() corrects a guess, so a
/// residual made with the previous velocities is the warm start of [Marinkovic & Zehn 2012].
/// Deterministic, for any number of threads: dot products are summed over fixed groups of nodes.
/// What it remembers between two solves is the matrix alone.
class PcgSolver final : public LinearSolver {
 public:
  /// `rest` may be null: then the preconditioner is BlockJacobi whatever `params` says. `team` may
  /// be null: then the caller works alone.
  PcgSolver(const SolverParams& params, const BlockPattern& pattern, const RestInverse* rest,
            ThreadTeam* team);

  using LinearSolver::factorize;
  SolveReport factorize(const BlockValues& A, const std::vector<NodeRotation>& rotations) override;
  /// Several columns go by eight at a time: see PcgColumns.
  SolveReport solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) override;
  SolveReport solve_roughly(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms,
                            Eigen::MatrixXd& left) override;

 private:
  SolveReport invert_diagonal(const BlockValues& A);
  SolveReport solve_columns(double tolerance, Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms,
                            Eigen::MatrixXd* left);
  /// Solves A x_ = r_.
  SolveReport solve_column(double b_norm);
  /// z_ = P⁻¹ r_; returns r_ · z_.
  double precondition(double residual);
  /// p_ = z_ + β p_.
  void turn_direction(double beta);
  /// Ap_ = A p_; returns p_ · Ap_.
  double multiply_direction();
  /// x_ += α p_, r_ −= α Ap_; returns ‖r_‖.
  double step(double alpha);
  /// Calls work(begin, end, sum) for groups of nodes and adds up the sums in their order.
  template <class Work>
  double sum_groups(const Work& work);

  SolverParams params_;
  const BlockPattern& pattern_;
  const RestInverse* rest_;
  ThreadTeam alone_;
  ThreadTeam& team_;
  const BlockValues* A_ = nullptr;
  std::vector<Padded> inverse_diagonal_;  ///< columns of the blocks
  std::vector<NodeRotation> rotations_;
  RestInverse::Scratch scratch_;
  std::vector<Padded> x_;
  std::vector<Padded> r_;
  std::vector<Padded> z_;
  std::vector<Padded> p_;
  std::vector<Padded> Ap_;
  std::vector<double> sums_;
  PcgColumns columns_;
};

}  // namespace tandem::fem
