#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "fem_process/solvers/linear_solver.h"

namespace tandem::fem {

/// Solves A X = B for a matrix near one that is factorised already: conjugate gradients to
/// round-off, preconditioned by z = W A₀⁻¹ Wᵀ r with the neighbour's A₀ and W = diag(R_i R_i0ᵀ),
/// the nodes' rotations since then. Where that takes more iterations than a factor costs, A is
/// factorised. A is symmetric and positive definite.
class NearbySolver final : public LinearSolver {
 public:
  /// The neighbour is factorised; all must outlive the solver. Without a team it runs on the
  /// caller's thread.
  NearbySolver(const BlockPattern& pattern, LinearSolver& neighbour,
               const std::vector<NodeRotation>& rotations, ThreadTeam* team = nullptr)
      : pattern_(pattern), neighbour_(neighbour), begin_(rotations), team_(team) {}

  SolveReport factorize(const BlockValues& A, const std::vector<NodeRotation>& rotations) override;
  SolveReport solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) override;

 private:
  /// A x = r; false: not within the iterations allowed.
  bool iterate(Eigen::VectorXd r, Eigen::VectorXd& x, SolveReport& report);
  SolveReport precondition(const Eigen::VectorXd& r, Eigen::MatrixXd& z);

  const BlockPattern& pattern_;
  LinearSolver& neighbour_;
  const std::vector<NodeRotation>& begin_;
  ThreadTeam* team_;
  const BlockValues* A_ = nullptr;
  std::vector<Eigen::Matrix3d> W_;
  std::unique_ptr<LinearSolver> own_;  ///< made when first needed
  bool factorised_ = false;            ///< own_ holds A
};

}  // namespace tandem::fem
