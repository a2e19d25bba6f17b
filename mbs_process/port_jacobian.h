#pragma once

#include <Eigen/Core>

#include "mbs_process/params.h"
#include "mbs_process/state.h"

namespace tandem::mbs {

/// By how much the wrench at a port is changed to measure the response.
struct ProbeSizes {
  double force_N;
  double torque_Nm;
};

/// Probes that would move the free body by kProbeMotion = 1e-6 (m, rad) within the step H:
///   δf (1/m + |r|²/I_min) H² = δt / I_mean · H² = kProbeMotion.
/// One step of ODE maps the wrench to the body's new twist by an affine function as long as no
/// limit, motor saturation or LCP active set switches, so the twist derivative is exact but for the
/// rounding ε |v| H / kProbeMotion. The pose is linear to h |w| kProbeMotion / 2 and rounded to
/// ε |p| / kProbeMotion ≈ 1e-10 m per unit. Over several micro steps the twist, too, is linear to
/// kProbeMotion only, as later steps start from poses and rates that the probe has changed.
[[nodiscard]] ProbeSizes probe_sizes(const BodyParams& body, const Eigen::Vector3d& p_BP,
                                     double macro_step_s);

/// One column of a port's 12 rows, [δp_WP | δθ_WP | δv_WP | δw_WP] / delta, from the end states of
/// the body without and with the probe. The body's own differences are taken first and carried to
/// the port by the exact chain rule, r = R_WB p_BP:
///   δp_WP = δp_WB + δθ × r,   δv_WP = δv_WB + δw × r + w × (δθ × r).
[[nodiscard]] Eigen::Matrix<double, 12, 1> port_derivative(const BodyState& base,
                                                           const BodyState& probed,
                                                           const Eigen::Vector3d& p_BP,
                                                           double delta);

}  // namespace tandem::mbs
