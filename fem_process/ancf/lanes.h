#pragma once

#include "fem_process/kernels/polar_lanes.h"
#include "fem_process/kernels/simd.h"

namespace tandem::fem::ancf {

/// Beam elements go four side by side: their points keep more numbers than eight lanes have
/// registers for.
constexpr int kLanes = 4;
using Lanes = Double4;
using LaneMatrix = fem::LaneMatrix<Lanes>;

}  // namespace tandem::fem::ancf
