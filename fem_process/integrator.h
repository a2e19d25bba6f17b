#pragma once

#include <Eigen/Core>
#include <memory>

#include "fem_process/params.h"
#include "fem_process/state.h"

namespace tandem::fem {

/// How one step of length h turns the unknown velocities v⁺ into positions and accelerations: the
/// affine maps
///   x⁺ = x̃ + d,  d = d̂ + c_x v⁺,   a⁺ = â + c_a v⁺
/// and the weight θ of the new state in the balance of forces
///   M a⁺ + θ r(v⁺, x⁺) + (1 − θ) r_n = reaction,   r = C v + f_int(x) − f_ext.
/// f_int and K are linearised at x̃, which does not depend on the step's input: repetitions of a
/// step share one factorisation.
struct StepMap {
  double c_x = 0.0;  ///< s
  double c_a = 0.0;  ///< 1/s
  double theta = 1.0;
  Eigen::VectorXd x_tilde;  ///< linearisation point (m)
  Eigen::VectorXd d_hat;    ///< m
  Eigen::VectorXd a_hat;    ///< m/s²
  /// Nodes with prescribed motion: a⁺ = â_p + c_a_p v⁺, and d from the prescribed position or, like
  /// free nodes, from the velocity.
  double c_a_prescribed = 0.0;
  Eigen::VectorXd a_hat_prescribed;
  bool prescribed_position = false;
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  [[nodiscard]] virtual StepMap map(const State& state, double h_s) const = 0;
  /// The accelerations that the next steps need, from the step's v⁺ and a⁺: a, a_mean and, where
  /// it is not a, acceleration. Linear in all arguments, so that it carries derivatives as well.
  virtual void keep(const State& begin, const Eigen::VectorXd& v, const Eigen::VectorXd& a,
                    double h_s, State& after) const = 0;
  /// Whether the state carries a and a_mean.
  [[nodiscard]] virtual bool keeps_history() const = 0;
  /// Whether the balance weighs old forces, θ < 1: the state then carries force and react.
  [[nodiscard]] virtual bool averages_forces() const = 0;
  /// Where the arms of the ports' torques stand: in the pose at the beginning of the step, or at
  /// its end. See TransientStep::advance.
  [[nodiscard]] virtual bool torque_arms_at_begin() const = 0;
  /// Whether reactions act constantly over the step, so that h times the reaction at its end is the
  /// impulse on the ports. Several such steps answer a macro step with the mean of their wrenches,
  /// which leaves the momentum as it is, and take their port velocities linear within it.
  [[nodiscard]] virtual bool constant_forces() const { return false; }
  /// Whether masses and velocities enter the balance; false: statics.
  [[nodiscard]] virtual bool inertia() const { return true; }
};

/// x⁺ = x + h v⁺, a⁺ = (v⁺ − v)/h, θ = 1, x̃ = x: (M + h C + h² K_R) v⁺ = M v + h (f_ext⁺ −
/// f_int(x)). First order, damps a mode of angular frequency ω by about ω² h/2 per second.
/// Prescribed nodes enter with the displacement h v⁺ [Marinkovic & Zehn 2012].
/// Angular momentum: x⁺ × M v⁺ − x × M v = x × M (v⁺ − v), because v⁺ × M v⁺ = 0. Forces that have
/// no moment about the positions at the beginning make none, so a port's torque is taken there;
/// with the arms at the end it would be wrong by h (w × r) × g, of the order of the step itself.
class BackwardEuler final : public Integrator {
 public:
  [[nodiscard]] StepMap map(const State& state, double h_s) const override;
  void keep(const State&, const Eigen::VectorXd&, const Eigen::VectorXd&, double,
            State&) const override {
    // x and v are all its history.
  }
  [[nodiscard]] bool keeps_history() const override { return false; }
  [[nodiscard]] bool averages_forces() const override { return false; }
  [[nodiscard]] bool torque_arms_at_begin() const override { return true; }
  [[nodiscard]] bool constant_forces() const override { return true; }
};

/// HHT-α [Hilber, Hughes, Taylor 1977], α in [−1/3, 0], second order:
///   M a⁺ + (1 + α) r⁺ − α r_n = 0
///   x⁺ = x + h v + h² ((½ − β) a + β a⁺),   v⁺ = v + h ((1 − γ) a + γ a⁺),
///   γ = ½ − α,  β = (1 − α)²/4.
/// Solved for v⁺, linearised at x̃ = x + h v: x⁺ − x̃ is O(h²), so what K_R leaves out costs O(h³)
/// per step and the order stays two without iterations. a⁺ belongs to t⁺ + α h, as HHT's does; for
/// prescribed nodes it comes from the difference formula of second order
///   a⁺ = ā + (½ + α)(ā − ā_n),   ā = (v⁺ − v)/h,
/// which forgets jumps of the prescribed velocity after two steps (Newmark's recursion would keep
/// them ringing for α = 0).
class Hht final : public Integrator {
 public:
  explicit Hht(double alpha) : alpha_(alpha) {}
  [[nodiscard]] StepMap map(const State& state, double h_s) const override;
  void keep(const State& begin, const Eigen::VectorXd& v, const Eigen::VectorXd& a, double h_s,
            State& after) const override;
  [[nodiscard]] bool keeps_history() const override { return true; }
  [[nodiscard]] bool averages_forces() const override { return true; }
  [[nodiscard]] bool torque_arms_at_begin() const override { return false; }

 private:
  double alpha_;
};

[[nodiscard]] std::unique_ptr<Integrator> make_integrator(const IntegratorParams& params);

}  // namespace tandem::fem
