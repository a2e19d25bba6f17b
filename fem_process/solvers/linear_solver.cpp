#include "fem_process/solvers/linear_solver.h"

#include "fem_process/solvers/cholmod_solver.h"
#include "fem_process/solvers/pcg_solver.h"

namespace tandem::fem {

std::unique_ptr<LinearSolver> make_solver(const SolverParams& params, const BlockPattern& pattern,
                                          const RestInverse* rest, ThreadTeam* team) {
  if (params.kind == SolverKind::Pcg) {
    return std::make_unique<PcgSolver>(params, pattern, rest, team);
  }
  return std::make_unique<CholmodSolver>(pattern);
}

}  // namespace tandem::fem
