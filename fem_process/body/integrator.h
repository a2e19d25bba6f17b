#pragma once

#include <Eigen/Core>
#include <complex>
#include <memory>

#include "fem_process/body/params.h"
#include "fem_process/body/state.h"

namespace tandem::fem {

/// How one step of length h turns the unknown velocities v⁺ into positions and accelerations: the
/// affine maps
///   x⁺ = x̃ + d,  d = d̂ + c_x v⁺,   a⁺ = â + c_a v⁺
/// in the balance of forces  M a⁺ + r(v⁺, x⁺) = reaction,   r = C v + f_int(x) − f_ext.
/// f_int and K are linearised at x̃, which does not depend on the step's input: repetitions of a
/// step share one factorisation.
struct StepMap {
  double c_x = 0.0;         ///< s
  double c_a = 0.0;         ///< 1/s
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
  /// What a and, where it is prescribed, a⁺ lack of a point that goes round with the body, which
  /// turns by `turn_rad` per step: see GeneralisedAlpha. Complex numbers are vectors across the
  /// axis.
  [[nodiscard]] virtual std::complex<double> circle_lead(double) const { return 0.0; }
  [[nodiscard]] virtual std::complex<double> prescribed_circle_lead(double) const { return 0.0; }
  /// Whether the state carries a and a_mean.
  [[nodiscard]] virtual bool keeps_history() const = 0;
  /// Whether reactions act constantly over the step, so that h times the reaction is the impulse on
  /// the ports. Several such steps answer a macro step with the mean of their wrenches, which
  /// leaves the momentum as it is, and take their port velocities linear within it. Their torques
  /// are about the ports' origins at the beginning of the macro step and close the angular momentum
  /// (AngularBalance); those of forces at the end of the step are about the origins there.
  [[nodiscard]] virtual bool constant_forces() const { return false; }
  /// Whether masses and velocities enter the balance; false: statics.
  [[nodiscard]] virtual bool inertia() const { return true; }
};

/// x⁺ = x + h v⁺, a⁺ = (v⁺ − v)/h, x̃ = x: (M + h C + h² K_R) v⁺ = M v + h (f_ext⁺ − f_int(x)).
/// First order, damps a mode of angular frequency ω by about ω² h/2 per second. Prescribed nodes
/// enter with the displacement h v⁺ [Marinkovic & Zehn 2012]. MiddleCarry takes the turning of the
/// body out of it.
class BackwardEuler final : public Integrator {
 public:
  [[nodiscard]] StepMap map(const State& state, double h_s) const override;
  void keep(const State&, const Eigen::VectorXd&, const Eigen::VectorXd&, double,
            State&) const override {
    // x and v are all its history.
  }
  [[nodiscard]] bool keeps_history() const override { return false; }
  [[nodiscard]] bool constant_forces() const override { return true; }
};

[[nodiscard]] std::unique_ptr<Integrator> make_integrator(const IntegratorParams& params);

}  // namespace tandem::fem
