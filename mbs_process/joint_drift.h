#pragma once

#include <optional>
#include <string>

#include "mbs_process/params.h"

namespace tandem::mbs {

/// How far the joints of a driven body are off. A step moves a body's centre along its tangent and
/// turns its arms r exactly, so at the rate w it misses the joint by ½ h² |w × (w × r)|, of which
/// the joint removes the share erp in each step: a steady error
///   e = ½ h² w² r / erp,   r from the centre of mass to the anchor, across the axis.
/// Of the bodies that motors turn, at their largest rates, and of these bodies' part alone.
struct JointDrift {
  double error_m = 0.0;  ///< largest; 0 where no motor turns an arm
  double arm_m = 0.0;    ///< r
  double rate_rad_per_s = 0.0;
  std::string joint;
};

/// At the micro step of `params`, over a run of duration_s. Without erp the error grows, e being
/// that at its end. Cost: up to 1e5 evaluations of each motor's law.
[[nodiscard]] JointDrift joint_drift(const Params& params, double duration_s);

/// "joint 'pin' will be off by about …" with the remedy where it is more than 5e-4 of the arm.
[[nodiscard]] std::optional<std::string> drift_warning(const Params& params, double duration_s);

}  // namespace tandem::mbs
