#include "mbs_process/joint_drift.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs_process/motor_rate.h"

namespace tandem::mbs {
namespace {

double step_s(const Params& params) {
  return to_seconds(params.micro_step.value_or(params.macro_step));
}

bool holds_a_point(JointKind kind) { return kind != JointKind::Slider && kind != JointKind::Fixed; }

}  // namespace

JointDrift joint_drift(const Params& params, double duration_s) {
  const double h_s = step_s(params);
  const double removed = std::max(params.erp, h_s / std::max(h_s, duration_s));
  JointDrift worst;
  for (const JointParams& driven : params.joints) {
    if (!driven.motor || driven.kind == JointKind::Slider) continue;
    const Eigen::Vector3d axis =
        (driven.motor->axis == 1 ? driven.axis_W : driven.axis2_W).normalized();
    const double rate = largest_motor_rate(*driven.motor, h_s, duration_s);
    const BodyParams& body = params.bodies[body_index(params, driven.body1).value()];
    for (const JointParams& joint : params.joints) {
      if (joint.body1 != body.name && joint.body2 != body.name) continue;
      if (!holds_a_point(joint.kind)) continue;
      const double arm_m = axis.cross(joint.p_WA - body.p_WB).norm();
      const double error_m = 0.5 * h_s * h_s * rate * rate * arm_m / removed;
      if (error_m <= worst.error_m) continue;
      worst = {.error_m = error_m, .arm_m = arm_m, .rate_rad_per_s = rate, .joint = joint.name};
    }
  }
  return worst;
}

std::optional<std::string> drift_warning(const Params& params, double duration_s) {
  const JointDrift found = joint_drift(params, duration_s);
  if (found.error_m <= 5e-4 * found.arm_m) return std::nullopt;
  return fmt::format(
      "joint '{}' will be off by about {:.3g} m: at {:.4g} rad/s a micro step of {:g} s misses the "
      "circle of {:.4g} m by h² w² r/2, and mbs.erp = {:g} of the error is removed per step. Set "
      "mbs.micro_step_s lower (half the step, a quarter of the error), or mbs.erp higher.",
      found.joint, found.error_m, found.rate_rad_per_s, step_s(params), found.arm_m, params.erp);
}

}  // namespace tandem::mbs
