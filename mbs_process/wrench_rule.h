#pragma once

#include "mbs_process/params.h"
#include "protocol/contract/port.h"

namespace tandem::mbs {

/// How the port wrenches λ, λ⁺ at both ends of a second-order step act in its two halves: by the
/// kinematics of Newmark's family, a = M⁻¹ λ̄,
///   x⁺ = x + h v + h² ((½ − β) a + β a⁺),   v⁺ = v + h ((1 − γ) a + γ a⁺),
///   (1 − α_m) λ̄⁺ + α_m λ̄ = (1 − α_f) λ⁺ + α_f λ.
/// `verlet`: λ̄ = λ, γ = ½. `generalised_alpha`: the weights of Chung and Hulbert for ρ∞, as the
/// flexible side's integrator of that name has them. What follows the wrench infinitely fast, a
/// light body on a stiff flexible one, then loses the share 1 − ρ∞ of its alternation in each step;
/// with β = ¼, γ = ½ it is kept for ever, and its velocity has the double root −1.
struct WrenchRule {
  double alpha_m = 0.0;
  double alpha_f = 0.0;
  double beta = 0.25;
  double gamma = 0.5;

  /// λ̄ at the end of a step.
  [[nodiscard]] WrenchSet filtered(const WrenchSet& before, const WrenchSet& begin,
                                   const WrenchSet& end) const;
  /// What acts in the first half, whose impulse is h/2 times it: (1 − 2 β) λ̄ + 2 β λ̄⁺.
  [[nodiscard]] WrenchSet first_half(const WrenchSet& before, const WrenchSet& after) const;
  /// The rest of 2 (1 − γ) λ̄ + 2 γ λ̄⁺.
  [[nodiscard]] WrenchSet second_half(const WrenchSet& before, const WrenchSet& after) const;
};

[[nodiscard]] WrenchRule wrench_rule(const Params& params);

/// Of the ports of junctions, which have no mass and follow their wrenches infinitely fast: of
/// second order with `verlet`, too, but damped. What is out of balance at t = 0, where flexible
/// bodies begin as if their ports kept their velocities, would alternate for ever.
[[nodiscard]] WrenchRule junction_rule(const Params& params);

}  // namespace tandem::mbs
