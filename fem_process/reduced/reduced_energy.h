#pragma once

#include "fem_process/reduced/reduced_step.h"

namespace tandem::fem {

/// Books a step of a reduced body in step.state, by the rules of book_step for a full one. The step
/// is the balance of power at its end, with Y the fields' positions, V their velocities, z = [ζ; η]
/// the coordinates with the stiffness K and i the inertia forces:
///   P = V·(i + α M V − f_ext) + ż·K (z + β ż) = −Σ λ·V_port,
/// λ with its arms at the end. Backward Euler (h i⁺ = M ΔV):
///   numerical = ½ ΔV·M ΔV + h ż⁺·K z⁺ − ΔU + f_ext⁺·(ΔY − h V⁺) + interface − h P⁺.
/// All others, the overline the mean of both ends and i = M q:
///   numerical = h mean(V·i) − ΔT + h mean(ż·K z) − ΔU + mean(f_ext)·ΔY − h mean(f_ext·V)
///               + interface − h mean(P).
void book_step(const ReducedModel& reduced, const ReducedState& begin, ReducedStep::Result& step);

/// Σ λ·V of the ports (W) of a state whose wrenches have their arms at its own time.
[[nodiscard]] double port_power_W(const ReducedState& state);

}  // namespace tandem::fem
