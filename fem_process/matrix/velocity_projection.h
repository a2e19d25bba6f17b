#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/block_matrix.h"

namespace tandem::fem {

/// The combination v = Σ y_k v_k of the last velocities that is nearest to the solution of S v = b
/// in the norm of S [Fischer 1998]: (v_jᵀ S v_k) y = v_jᵀ b. Velocities whose new part is round-off
/// are left out. The same bits for any number of threads.
[[nodiscard]] Eigen::VectorXd project(const EightVectors& past, const EightVectors& S_past,
                                      const Eigen::VectorXd& b, ThreadTeam& team);

}  // namespace tandem::fem
