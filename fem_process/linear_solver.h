#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "fem_process/block_matrix.h"
#include "protocol/contract/subsystem.h"

namespace tandem::fem {

enum class SolverKind { Cholmod, Pcg };

struct SolverParams {
  SolverKind kind = SolverKind::Cholmod;
  double tolerance = 1e-12;  ///< PCG: ‖b − A v‖₂ ≤ tolerance ‖b‖₂
  int max_iterations = 5000;
};

struct SolveReport {
  Outcome outcome = Outcome::Done;
  std::string message{};  ///< empty when Done
  int iterations = 0;     ///< 0 for direct solvers
};

/// Solves A X = B for a symmetric positive definite block matrix of fixed pattern.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  /// Takes the values of A. Failed when A is found not to be positive definite.
  virtual SolveReport factorize(const BlockValues& A) = 0;

  /// Corrects a guess: solves A δ = r, one column per right-hand side, and overwrites r with δ.
  /// `b_norms` are the norms that an iterative solver measures its residuals by.
  virtual SolveReport solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) = 0;
};

/// The pattern must outlive the solver.
[[nodiscard]] std::unique_ptr<LinearSolver> make_solver(const SolverParams& params,
                                                        const BlockPattern& pattern);

}  // namespace tandem::fem
