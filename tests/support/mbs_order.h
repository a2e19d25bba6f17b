#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/support/jacobi_elliptic.h"
#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {

/// Expects error(h) ∝ h^order within ± 0.15 over four halvings from `coarsest`. The window is that
/// of the next term of the error's expansion, which a first-order method still shows.
inline void expect_order(double order, SimTime coarsest,
                         const std::function<double(SimTime)>& error) {
  double previous = error(coarsest);
  for (int halving = 1; halving <= 4; ++halving) {
    const double finer = error(coarsest / (1 << halving));
    EXPECT_NEAR(std::log2(previous / finer), order, 0.15)
        << "halving " << halving << ": " << previous << " -> " << finer;
    previous = finer;
  }
}

/// Rod-like pendulum on a hinge along −y, centre of mass at distance l, moment I_A about the hinge,
/// released from rest at θ0 from hanging straight down:
///   sin(θ/2) = k cd(ω0 t, k),   k = sin(θ0/2),   ω0² = m g l / I_A.  [Abramowitz & Stegun 16.3]
struct PhysicalPendulum {
  double l = 0.5, g = 9.81, mass = 2.0, moment = 0.3, theta0 = 2.0;

  [[nodiscard]] double omega0() const { return std::sqrt(mass * g * l / (moment + mass * l * l)); }
  [[nodiscard]] double angle(double t_s) const {
    const double k = std::sin(theta0 / 2);
    const JacobiElliptic f = jacobi_elliptic(omega0() * t_s, k);
    return 2.0 * std::asin(k * f.cn / f.dn);
  }
  /// Speed of the centre of mass on its circle: ½ θ̇² = ω0² (cos θ − cos θ0).
  [[nodiscard]] double speed(double t_s) const {
    return l * omega0() * std::sqrt(2.0 * std::max(0.0, std::cos(angle(t_s)) - std::cos(theta0)));
  }
  void add_to(Params& params) const {
    params.gravity_m_per_s2 = {0.0, 0.0, -g};
    const Eigen::Vector3d p(l * std::sin(theta0), 0.0, -l * std::cos(theta0));
    params.bodies = {body_at("bob", mass, p, {0.3, moment, 0.2})};
    params.joints = {joint_between("pivot", JointKind::Hinge, "bob", kWorld,
                                   Eigen::Vector3d::Zero(), -Eigen::Vector3d::UnitY())};
  }
};

/// Largest errors of a run: one at a single instant may pass through zero.
struct PendulumErrors {
  double angle_rad = 0.0;
  double speed_m_per_s = 0.0;
};
/// Over one second from rest with the integrator of `params` and steps of h.
inline PendulumErrors pendulum_errors(Params params, SimTime h) {
  const PhysicalPendulum pendulum;
  pendulum.add_to(params);
  RigidWorld world(params);
  PendulumErrors errors;
  const int n = static_cast<int>(std::lround(1.0 / to_seconds(h)));
  for (int i = 1; i <= n; ++i) {
    run(world, h, 1);
    const double t_s = to_seconds(world.state().time);
    const double angle = pendulum.theta0 + world.state().joint_coordinates[0][0];
    errors.angle_rad = std::max(errors.angle_rad, std::abs(angle - pendulum.angle(t_s)));
    errors.speed_m_per_s = std::max(
        errors.speed_m_per_s, std::abs(world.state().bodies[0].v_WB.norm() - pendulum.speed(t_s)));
  }
  return errors;
}

}  // namespace tandem::mbs::testing
