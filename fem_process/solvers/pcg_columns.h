#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/kernels/simd.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/block_matrix.h"
#include "fem_process/solvers/linear_solver.h"
#include "fem_process/solvers/rest_inverse.h"

namespace tandem::fem {

/// What PCG solves with: the matrix and its preconditioner.
struct PcgSystem {
  const BlockPattern& pattern;
  const BlockValues& A;
  const RestInverse* rest = nullptr;  ///< null: the inverse diagonal blocks
  const std::vector<Padded>& inverse_diagonal;
  const std::vector<NodeRotation>& rotations;
  ThreadTeam& team;
};

/// Preconditioned conjugate gradients for up to eight right-hand sides side by side: every column
/// has its own numbers α and β, as if it were alone, but matrix and preconditioner are read once
/// for all of them. A column that has converged stays as it is. Deterministic, for any number of
/// threads.
class PcgColumns {
 public:
  using Eight = RestInverse::Eight;

  /// Solves A x = r in the first `columns` columns, the others of r must be zero, until
  /// ‖r − A x‖ ≤ limit; r becomes r − A x. Iterations are counted per column.
  SolveReport solve(const PcgSystem& system, const Eight& limits, int columns, int max_iterations,
                    EightVectors& r, EightVectors& x);

 private:
  Eight precondition(const PcgSystem& system, const Eight& residual, int columns,
                     const EightVectors& r);
  /// Calls work(begin, end, sums) for groups of nodes and adds up the sums in their order.
  template <class Work>
  Eight sum_groups(ThreadTeam& team, std::size_t nodes, const Work& work);

  RestInverse::Scratch scratch_;
  EightVectors z_;
  EightVectors p_;
  EightVectors Ap_;
  std::vector<double> sums_;
};

}  // namespace tandem::fem
