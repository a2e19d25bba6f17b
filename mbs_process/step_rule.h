#pragma once

#include "mbs_process/params.h"

namespace tandem::mbs {

/// What one dWorldStep takes of the loads, and how soft its rows are:
///   joints  J v⁺ + cfm μ = −(erp / h) φ,   stops  the same with ≥ and μ ≥ 0,
///   motors  J v⁺ + motor_cfm μ = speed with |μ| ≤ share · largest effort.
struct StepRule {
  double share = 1.0;  ///< of gravity, of applied wrenches, of the largest efforts
  double erp = 0.0;
  double cfm = 0.0;
  double motor_cfm = 0.0;
};

/// A step of semi-implicit Euler. At rest, v⁺ = 0, a joint under the load F has given way by
///   φ = cfm F h / erp:
/// it is the spring k = erp / (h cfm) with the damper c = (1 − erp) / cfm, F = −(k φ⁺ + c v⁺) where
/// φ⁺ = φ + h v⁺. A motor falls behind its speed by cfm F.
[[nodiscard]] StepRule whole_step(const Params& params);

/// The halves of a Verlet step (see RigidWorld), each with half the loads: μ is half the force, so
/// rows as soft as those of a whole step have 2 cfm, and motors yield at half their effort.
///
/// The first half moves the poses, J(x) u + 2 cfm μ = −(erp / h) φ(x): spring and damper as above,
///   2 μ = −(k φ⁺ + c u).
[[nodiscard]] StepRule first_half(const Params& params);

/// The second half makes the velocity at the end. Of a rigid joint that is J(x⁺) v⁺ = 0: what erp
/// would add there is the step's chord, not a motion, and of first order. Of a soft one it is
///   2 μ = −(k φ⁺ + c' v⁺),   c' = c + h / (cfm² m),
/// the same spring with a damper that turns rigid where a step does not resolve the joint,
/// h ≫ cfm m, and is c where it does; m is the smallest mass (kg). In terms of the row, with
/// s = 1 / (1 − erp + h / (cfm m)),
///   J(x⁺) v⁺ + 2 s cfm μ = −(s erp / h) φ(x⁺).
/// Both halves are at rest, u = v⁺ = 0, at φ = cfm F h / erp, like a whole step.
/// Joints that constrain a motion twice need some softness, too: it is at least 1e-8 h / m, which
/// leaves 5e-9 of a step's acceleration as velocity, or cfm where that is less.
[[nodiscard]] StepRule second_half(const Params& params, double h_s);

}  // namespace tandem::mbs
