#pragma once

#include <optional>
#include <vector>

#include "mbs_process/params.h"
#include "orchestrator/scenario/model.h"
#include "orchestrator/warnings/finding.h"

namespace tandem::orchestrator {

/// Gravity that only one side has, or that differs. Not for quasi_static and nodal flexible sides,
/// whose masses stand in the multibody side.
[[nodiscard]] std::optional<Finding> gravity_on_one_side(const scenario::Node& root);

/// An integrator of second order on one side of a mesh only: the run is of first order.
[[nodiscard]] std::optional<Finding> orders_differ(const scenario::Node& root);

/// The fastest turning that motors prescribe and initial velocities give, times H, where that is
/// above VerdictLimits::kTurn_rad. Not for adaptive steps, which find their own.
[[nodiscard]] std::optional<Finding> turn_per_step(const Model& model, const mbs::Params& params);

/// Tolerances set by hand that are coarser than run.accuracy: what they leave in the wrench is more
/// than the run is asked for.
[[nodiscard]] std::vector<Finding> coarse_tolerances(const scenario::Node& root);

}  // namespace tandem::orchestrator
