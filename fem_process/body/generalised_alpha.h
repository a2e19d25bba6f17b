#pragma once

#include "fem_process/body/integrator.h"

namespace tandem::fem {

/// Generalised-α [Chung & Hulbert 1993] and, with α_m = α_f = 0, Newmark's method:
///   x⁺ = x + h v + h² ((½ − β) a + β a⁺),   v⁺ = v + h ((1 − γ) a + γ a⁺),
///   (1 − α_m) a⁺ + α_m a = (1 − α_f) q⁺ + α_f q,   M q⁺ + r⁺ = reaction.
/// a is Newmark's acceleration (it belongs to t + (α_m − α_f) h), q the acceleration of the balance
/// of forces at t. Where the balance holds at every t this is Chung and Hulbert's weighted balance
///   M ((1 − α_m) a⁺ + α_m a) + (1 − α_f) r⁺ + α_f r = 0;
/// written so, the reactions of prescribed nodes are those of the end of the step and no recursion
/// of weighted reactions is needed [Arnold & Brüls 2007].
/// Solved for v⁺, linearised at x̃ = x + h v: x⁺ − x̃ is O(h²), so what K_R leaves out costs O(h³)
/// per step and the order stays two without iterations. EndCarry takes the turning of the body out
/// of the step, and puts x̃ where it is next to it. Prescribed nodes: q⁺ = ā + ½ (ā − ā_n) with ā =
/// (v⁺ − v)/h, second order, which forgets jumps of the prescribed velocity after two steps.
/// Impulse: the sum of h times the wrenches differs from the change of momentum by terms of the
/// first and the last two steps alone; it does not grow.
///
/// A point that goes round on a circle, its velocity turning by θ per step, z = exp(iθ): the
/// recursion differences chords: q is θ²/12 or more too large, and turned where weights damp. With
///   Γ a⁺ + (1 − Γ) a = (v⁺ − v)/h,   Γ = γ − i k + (α_f − α_m) (g − 1),
///   k = 1/θ − ½ cot(θ/2) = θ/12 + …,   g = (z − 1)/(iθ)/((1 − α_f) z + α_f)
/// q is ω × v where the weights are of second order (γ = ½ + α_f − α_m), and at constant
/// accelerations what it was. i k is the end correction of the trapezoidal rule, h²/12 of the
/// change of a˙ = ω × a, fitted; Γ keeps what γ has: sums over steps telescope, and with γ = ½
/// no motion, of any frequency, gains or loses energy. Γ is γ with v⁺ + σ in place of v⁺,
///   σ = h X ((v⁺ − v)/h − a),   X = γ/Γ − 1 (circle_lead).
/// Prescribed nodes: q⁺ = ā + (½ + L) (ā − ā_n) with L = −k θ + i (k + θ/4 − k² θ)
/// (prescribed_circle_lead). Both are held from 2 rad per step on: they end at a whole turn.
class GeneralisedAlpha final : public Integrator {
 public:
  struct Weights {
    double alpha_m = 0.0;
    double alpha_f = 0.0;
    double beta = 0.25;
    double gamma = 0.5;
  };
  /// Weights of second order, with the least damping of slow motion for the spectral radius
  /// ρ∞ in [0, 1] of infinitely fast ones:
  ///   α_m = (2 ρ∞ − 1)/(ρ∞ + 1),  α_f = ρ∞/(ρ∞ + 1),
  ///   γ = ½ − α_m + α_f,  β = (1 − α_m + α_f)²/4.
  [[nodiscard]] static Weights weights_of(double rho_infinity);
  /// HHT-α [Hilber, Hughes, Taylor 1977], α in [−1/3, 0]: the weighted balance
  ///   M a⁺ + (1 + α) r⁺ − α r = 0,
  /// which is α_m = 0, α_f = −α, γ = ½ − α, β = (1 − α)²/4.
  [[nodiscard]] static Weights weights_of_hht(double alpha);

  explicit GeneralisedAlpha(const Weights& weights) : weights_(weights) {}
  [[nodiscard]] StepMap map(const State& state, double h_s) const override;
  void keep(const State& begin, const Eigen::VectorXd& v, const Eigen::VectorXd& a, double h_s,
            State& after) const override;
  [[nodiscard]] bool keeps_history() const override { return true; }
  [[nodiscard]] std::complex<double> circle_lead(double turn_rad) const override;
  [[nodiscard]] std::complex<double> prescribed_circle_lead(double turn_rad) const override;

 private:
  Weights weights_;
};

}  // namespace tandem::fem
