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

/// Input at t + s H, s in [0, 1]. s = 1 returns `end` bit for bit.
/// Motion: position and velocity by the cubic Hermite polynomial through both ends' positions and
/// velocities (H in s), rotation by slerp, angular velocity linear. Wrench: linear.
[[nodiscard]] MotionSet interpolate(const Segment<MotionSet>& input, double s, SimTime H);
[[nodiscard]] WrenchSet interpolate(const Segment<WrenchSet>& input, double s, SimTime H);

}  // namespace tandem
