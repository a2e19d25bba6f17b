#include "fem_process/linear_solver.h"

#include "fem_process/cholmod_solver.h"
#include "fem_process/pcg_solver.h"

namespace tandem::fem {

std::unique_ptr<LinearSolver> make_solver(const SolverParams& params, const BlockPattern& pattern,
                                          const RestInverse* rest, ThreadTeam* team) {
  if (params.kind == SolverKind::Pcg) {
    return std::make_unique<PcgSolver>(params, pattern, rest, team);
  }
  return std::make_unique<CholmodSolver>(pattern);
}

}  // namespace tandem::fem
