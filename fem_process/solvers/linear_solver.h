#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/block_matrix.h"
#include "fem_process/matrix/node_rotations.h"
#include "protocol/contract/subsystem.h"

namespace tandem::fem {

class RestInverse;

enum class SolverKind { Cholmod, Pcg };

/// P ≈ A of preconditioned conjugate gradients.
enum class PreconditionerKind {
  BlockJacobi,       ///< the 3×3 diagonal blocks of A
  RestFactor,        ///< A₀ = L Lᵀ, A at the reference positions
  WarpedRestFactor,  ///< W A₀ Wᵀ, W the nodes' rotations since then [Courtecuisse et al. 2010]
  WarpedRestMultigrid,  ///< W B Wᵀ, B ≈ A₀⁻¹ a cycle of multigrid: RestMultigrid
  Automatic             ///< WarpedRestFactor, of large meshes WarpedRestMultigrid
};

/// Where PCG starts.
enum class InitialGuess {
  Previous,   ///< the last velocities [Marinkovic & Zehn 2012]
  Projection  ///< the best combination of the last eight in the norm of A [Fischer 1998]
};

struct SolverParams {
  SolverKind kind = SolverKind::Cholmod;
  double tolerance = 1e-12;  ///< PCG: ‖b − A v‖₂ ≤ tolerance ‖b‖₂
  int max_iterations = 5000;
  /// PCG: takes what max_iterations have reached, with its residual, as a solution [MZ12].
  bool accept_unconverged = false;
  PreconditionerKind preconditioner = PreconditionerKind::Automatic;
  InitialGuess initial_guess = InitialGuess::Projection;
};

struct SolveReport {
  Outcome outcome = Outcome::Done;
  std::string message{};  ///< empty when Done
  int iterations = 0;     ///< 0 for direct solvers
  double residual = 0.0;  ///< largest norm of a right-hand side that is left; 0 for direct solvers
};

/// Solves A X = B for a symmetric positive definite block matrix of fixed pattern.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  /// Takes the values of A; an iterative solver refers to them until the next call. Failed when A
  /// is found not to be positive definite. `rotations` of the nodes since the reference positions
  /// help a warped preconditioner; empty: none.
  virtual SolveReport factorize(const BlockValues& A,
                                const std::vector<NodeRotation>& rotations) = 0;
  SolveReport factorize(const BlockValues& A) { return factorize(A, {}); }

  /// Corrects a guess: solves A δ = r, one column per right-hand side, and overwrites r with δ.
  /// `b_norms` are the norms that an iterative solver measures its residuals by.
  virtual SolveReport solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) = 0;

  /// The same with the square root of an iterative solver's tolerance; `left` = r − A δ, zero where
  /// the solver is exact. For products aᵀ A⁻¹ r of symmetric systems, whose error is then of second
  /// order: see StepTangent.
  virtual SolveReport solve_roughly(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms,
                                    Eigen::MatrixXd& left) {
    left.setZero(r.rows(), r.cols());
    return solve(r, b_norms);
  }
};

/// The pattern, the factor and the team must outlive the solver. Without a factor PCG uses the
/// diagonal blocks, without a team it runs on the caller's thread.
[[nodiscard]] std::unique_ptr<LinearSolver> make_solver(const SolverParams& params,
                                                        const BlockPattern& pattern,
                                                        const RestInverse* rest = nullptr,
                                                        ThreadTeam* team = nullptr);

}  // namespace tandem::fem
