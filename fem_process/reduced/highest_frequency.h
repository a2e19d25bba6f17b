#pragma once

#include "fem_process/body/model.h"

namespace tandem::fem {

/// Highest angular frequency (rad/s) of the free nodes at rest with lumped masses,
///   K φ = ω² M φ,
/// by Lanczos' iteration on M^(−1/2) K M^(−1/2). The bound of its residual is added: never below
/// the largest Ritz value, above ω by less than 1 % where the iteration has found it. The start is
/// fixed, and with it every bit. Zero without free nodes.
[[nodiscard]] double highest_angular_frequency(const Model& model);

/// The same with the masses that the steps use, model.mass: consistent ones put it up to √5 times
/// higher on first-order tetrahedra.
[[nodiscard]] double highest_step_frequency(const Model& model);

/// Largest step (s) at which Newmark's rule with γ ≥ ½ is stable for undamped motion of angular
/// frequency w (rad/s): 1/(w √(γ/2 − β)); infinite for β ≥ γ/2.
[[nodiscard]] double newmark_step_limit_s(double beta, double gamma, double w);

/// Largest step H (s) at which symplectic Euler of the nodes,
///   v⁺ = v + H M⁻¹ (f − K x − C v),   x⁺ = x + H v⁺,
/// is stable at rest: H = 2 (√(1 + ζ²) − ζ) / ω, the smallest over all modes, which is that of the
/// highest one with ζ = (α/ω + β ω)/2. Infinite without stiffness and damping.
[[nodiscard]] double explicit_step_limit_s(const Model& model);

}  // namespace tandem::fem
