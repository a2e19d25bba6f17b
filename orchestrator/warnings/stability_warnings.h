#pragma once

#include "fem_process/body/model.h"
#include "mbs_process/params.h"
#include "orchestrator/scenario/model.h"
#include "orchestrator/warnings/finding.h"
#include "protocol/contract/port.h"

namespace tandem::orchestrator {

/// A flexible side by Newmark's rule with β < γ/2, in steps beyond its limit 1/(ω √(γ/2 − β)), ω
/// the highest frequency of the mesh at rest with its ports held. Not for reduced bodies.
[[nodiscard]] std::optional<Finding> unstable_newmark(const scenario::Node& root,
                                                      const fem::Model& model);

/// Stiffness of the rigid ports' six motions each at rest, about `origins`, all other nodes held:
/// what a port feels of motion faster than the body can follow (N, N·m against m, rad).
[[nodiscard]] Eigen::MatrixXd port_stiffness(const fem::Model& model, const MotionSet& origins);

/// The fastest oscillation of the rigid bodies on that stiffness, ω H at run.macro_step_s.
struct PortOscillation {
  std::string port;
  double angle_rad = 0.0;
};
[[nodiscard]] PortOscillation fastest_port(const Model& model, const mbs::Params& params,
                                           const fem::Model& body);

/// Limit of ω H of Verlet's rule with β < 1/4: 2/√(1 − 4 β).
[[nodiscard]] double verlet_limit_rad(double beta);

/// mbs.newmark_beta below 1/4 beyond that limit. Rigid ports of full bodies.
[[nodiscard]] std::optional<Finding> unstable_verlet(const Model& model, const mbs::Params& params,
                                                     const fem::Model& body);

}  // namespace tandem::orchestrator
