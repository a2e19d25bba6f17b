#pragma once

#include "protocol/contract/port.h"

namespace tandem::fem {

/// Σ ½ (λ + λ⁺)·Δ(pose) over the ports (J): the trapezoid of the work that wrenches do on a step
/// between the motions at its ends, rotations by the vector of difference().
[[nodiscard]] double interface_trapezoid_J(const MotionSet& begin, const MotionSet& end,
                                           const WrenchSet& at_begin, const WrenchSet& at_end);

}  // namespace tandem::fem
