#pragma once

#include <ode/ode.h>

#include <array>

#include "mbs_process/params.h"

// ODE's joints behind one set of functions; for OdeWorld alone.
namespace tandem::mbs {

/// The joint as it holds body1 to body2 (null: the world) in their present poses, with neither stop
/// nor motor.
dJointID create_joint(dWorldID world, const JointParams& params, dBodyID body1, dBodyID body2);

/// A row of its own along (slider) or about one axis of the joint, with neither stop nor motor yet.
dJointID create_row(dWorldID world, const JointParams& params, int axis, dBodyID body1,
                    dBodyID body2);

/// Sets a parameter (dParam…) of the stop or motor of a slider or of a row of its own.
void set_parameter(dJointID joint, int parameter, double value);

/// The erp and cfm of the joint's or stop's rows in the next step; the world's must be the same.
void set_softness(dJointID joint, double erp, double cfm);

/// Coordinates as ODE measures them, angles in [−π, π]; 0 where the joint has none.
std::array<double, 2> coordinates_of(dJointID joint);
/// Their rates; of a hinge2 whose axes are not perpendicular, w · axis.
std::array<double, 2> rates_of(dJointID joint);

}  // namespace tandem::mbs
