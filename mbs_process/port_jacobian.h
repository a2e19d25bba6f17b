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

/// r×, with r× a = r × a.
[[nodiscard]] Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& r);

/// dθ / d(h w) of x ⊕ h w = exp(h w) R, a rotation about the axes of W (the left Jacobian of
/// SO(3)):
///   1 + (1 − cos φ) / φ² (h w)× + (φ − sin φ) / φ³ (h w)×²,   φ = |h w|.
[[nodiscard]] Eigen::Matrix3d turn_by_rate(const Eigen::Vector3d& turn);

/// A port's 12 rows, [δp_WP | δθ_WP | δv_WP | δw_WP], by the change [δv_WB | δw_WB] of its body's
/// twist at the end of a step from one pose, x⁺ = x ⊕ h v⁺; `end` is the body's state there.
[[nodiscard]] Eigen::Matrix<double, 12, 6> port_change_by_twist(const BodyState& end,
                                                                const Eigen::Vector3d& p_BP,
                                                                double h_s);

}  // namespace tandem::mbs
