#pragma once

#include "fem_process/turning/carry.h"

namespace tandem::fem {

/// Carry of backward Euler, in the axes at the middle of the step's turn. With the mean motion (c,
/// V, ω) of a part at the beginning of the step, ω of its angular momentum, and Q = exp(h [ω]×):
///   x̃ = c + Q^½ (x − c),   V̂ = ω × Q (x − c),   y = v⁺ − V̂   (what the plain step solves for),
///   M (v⁺ − v)/h + T f(x̃) + K(x̃) d + C (y − y_ref) = f_ext + reaction,   d = h y,
///   x⁺ = c + Q (x − c) + h Ȳ + Q^½ (d − h Ȳ) + Σ_k φ_k e_k,   Ȳ the mean of y.
/// The matrix M + h C + h² K is that of the plain step. T f is the mean over the step of the force
/// that turns with the body; forces on the free nodes sum to zero with it as without, so that
/// linear momentum closes to round-off. Elastic displacements are turned by half, as their forces
/// are: turning one of the two alone would feed whirling. e_k = p_k⁺ − (where the same rule takes
/// the origin of port k): what the port's own integrator makes of the motion of its origin.
///
/// y_ref is the rigid motion of the mean of the holders with the velocities v_k + ε_k, less
/// Σ_k φ_k ε_k, ε_k = ω × Q r_k − (Q − 1) r_k / h for ports that step by h v⁺ (State::port_chords):
/// a tangent for the chord of a circle, which is no strain rate of the body.
///
/// In steady turning, about any axis, y = V̄ everywhere: T f(x̃) = −M (v⁺ − v)/h is the centrifugal
/// load of the mean acceleration sin(ωh/2)/(ωh/2) ω² r, and T takes the same part of f.
class MiddleCarry final : public Carry {
 public:
  MiddleCarry(const Model& model, const LoosePorts& loose) : Carry(model, loose) {}

  [[nodiscard]] Carried begin(const State& state, double h_s) const override;
  [[nodiscard]] MotionSet seen(const Carried& carried, const MotionSet& end) const override;
  [[nodiscard]] Eigen::VectorXd drift(const Carried&, const MotionSet&) const override {
    return {};  // the balance takes the displacements of all nodes from their velocities
  }
  void take_mean(const Carried& carried, Eigen::VectorXd& f) const override;
  void see_prescribed(const Carried& carried, Eigen::VectorXd& v) const override;
  [[nodiscard]] Eigen::VectorXd prescribed_shift(const Carried&, const MotionSet&,
                                                 const Eigen::VectorXd& x,
                                                 const Eigen::VectorXd&) const override {
    return Eigen::VectorXd::Zero(x.size());
  }
  void conclude(const State& begin, const Carried& carried, Made made, State& after) const override;

 private:
  void refer(std::size_t s, const State& begin, const Carried& carried, const MotionSet& end,
             Eigen::VectorXd& v) const override;
  /// The ground, at rest at `at`, as the picture has it at the end of the step.
  [[nodiscard]] Motion seen_ground(const Carried::Turn& turn, const Eigen::Vector3d& at) const;
};

/// State::port_chords of a macro step: from ports at its ends, so that nothing within the step
/// depends on it.
[[nodiscard]] Eigen::VectorXd port_chords(const MotionSet& begin, const MotionSet& end, double H_s);

}  // namespace tandem::fem
