#pragma once

#include <Eigen/Core>

#include "fem_process/body/model.h"

namespace tandem::fem {

/// What the rounding of the positions leaves of internal forces (N): the norm of ε ‖K_ii‖ ‖x_i‖
/// over the free nodes. No iteration gets a residual much below it.
[[nodiscard]] double round_off(const Model& model, const BlockValues& K, const Eigen::VectorXd& x);

}  // namespace tandem::fem
