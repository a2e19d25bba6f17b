#pragma once

#include "protocol/contract/port.h"
#include "protocol/contract/sim_time.h"

namespace tandem {

/// An input over one macro step: its value at both ends, [t, t + H].
template <class T>
struct Segment {
  T begin;
  T end;
};

/// What the velocity of an interpolated motion is.
enum class VelocityRule {
  Derivative,  ///< of the interpolated position: second order for positions and velocities that
               ///< belong together to that order
  Linear,      ///< between both ends, so that the acceleration is constant over the macro step
};

/// Input at t + s H, s in [0, 1]. s = 1 returns `end` bit for bit.
/// Motion: position by the cubic Hermite polynomial through both ends' positions and velocities
/// (H in s), rotation by slerp, angular velocity linear, velocity by the rule. A step of first
/// order, p⁺ = p + H v⁺, does not say with its ends how the velocity changes in between: the
/// polynomial's acceleration would be 4 a at the beginning and −2 a at the end, a = (v⁺ − v)/H.
/// Wrench: linear.
[[nodiscard]] MotionSet interpolate(const Segment<MotionSet>& input, double s, SimTime H,
                                    VelocityRule rule = VelocityRule::Derivative);
[[nodiscard]] WrenchSet interpolate(const Segment<WrenchSet>& input, double s, SimTime H);

}  // namespace tandem
