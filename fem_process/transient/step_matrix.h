#pragma once

#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/block_matrix.h"

namespace tandem::fem {

/// S_II = m M + k K on the pattern of the free nodes: `interior` says where its blocks stand in M
/// (kg, one number per block) and K (N/m; null: none).
void combine(const SubPattern& interior, double m, const std::vector<double>& M, double k,
             const BlockValues* K, BlockValues& S, ThreadTeam& team);

}  // namespace tandem::fem
