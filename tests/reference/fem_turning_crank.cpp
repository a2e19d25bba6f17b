#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "tests/support/fem_ports.h"
#include "tests/support/fem_support.h"
#include "tests/support/turning_bar.h"

// The bar of turning_bar.h on a crank: its port goes round itself.
namespace tandem::fem {
namespace {

using namespace testing;

/// From 0 to 1 within `end_s`, its first two derivatives steady; and its integrals over time. An
/// undamped method keeps as a part that alternates what its accelerations begin with.
struct Ramp {
  double end_s;
  [[nodiscard]] double value(double t) const {
    const double s = std::min(t / end_s, 1.0);
    return s - std::sin(2.0 * M_PI * s) / (2.0 * M_PI);
  }
  [[nodiscard]] double first(double t) const {
    const double s = std::min(t / end_s, 1.0);
    const double within = 0.5 * s * s + (std::cos(2.0 * M_PI * s) - 1.0) / (4.0 * M_PI * M_PI);
    return end_s * within + std::max(t - end_s, 0.0);
  }
  [[nodiscard]] double second(double t) const {
    const double s = std::min(t / end_s, 1.0);
    const double within =
        s * s * s / 6.0 + (std::sin(2.0 * M_PI * s) / (2.0 * M_PI) - s) / (4.0 * M_PI * M_PI);
    const double after = std::max(t - end_s, 0.0);
    return end_s * end_s * within + 0.5 * end_s * after + 0.5 * after * after;
  }
};

/// The same bar on a crank: its port goes round at 2 m from a shaft, which is accelerated.
struct Crank {
  static constexpr double kRadius_m = 2.0;
  static Eigen::Vector3d shaft() { return kAxisPoint - Eigen::Vector3d(kRadius_m, 0.0, 0.0); }
  Ramp ramp;
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d shaft_at(double t) const {
    return shaft() + ramp.second(t) * acceleration;
  }
  [[nodiscard]] Eigen::Quaterniond turn(double t) const {
    return rotation(Eigen::Vector3d(0.0, 0.0, kRate_rad_per_s * ramp.first(t)));
  }
  [[nodiscard]] MotionSet motion(double t) const {
    const Eigen::Vector3d w(0.0, 0.0, kRate_rad_per_s * ramp.value(t));
    const Eigen::Vector3d r = turn(t) * Eigen::Vector3d(kRadius_m, 0.0, 0.0);
    return {{.p_WP = shaft_at(t) + r,
             .q_WP = turn(t),
             .v_WP = ramp.first(t) * acceleration + w.cross(r),
             .w_WP = w}};
  }
};

/// Means over the last steps on the crank.
struct Held {
  Eigen::Vector3d in_W = Eigen::Vector3d::Zero();     ///< force less what is `outward` of it (N)
  Eigen::Vector3d turning = Eigen::Vector3d::Zero();  ///< force in the axes of the bar (N)
  double torque_Nm = 0.0;                             ///< about the shaft
  EnergyBook energy;
};

void hold(FlexibleBody& body, const Crank& crank, int steps, double outward_N, Held& held) {
  const SimTime micro_step = body.model().params.micro_step;
  const double h = to_seconds(micro_step);
  const bool means = body.model().integrator->constant_forces();
  body.initialize(crank.motion(0.0));
  const int last = 100;
  for (int k = 1; k <= steps; ++k) {
    const MotionSet begin = crank.motion((k - 1) * h);
    const MotionSet end = crank.motion(k * h);
    const auto result = body.advance(request(begin, end, micro_step));
    ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
    if (k <= steps - last) continue;
    const Wrench& wrench = result.output[0];
    // A mean over the step has the direction of its middle; the torque of constant forces is about
    // the port at its beginning.
    const Eigen::Quaterniond turn = crank.turn(means ? (k - 0.5) * h : k * h);
    held.turning += turn.conjugate() * wrench.f_P_W / last;
    held.in_W += (wrench.f_P_W - outward_N * (turn * Eigen::Vector3d::UnitX())) / last;
    const Eigen::Vector3d arm = (means ? begin : end)[0].p_WP - crank.shaft_at(k * h);
    held.torque_Nm += (wrench.t_P_W + arm.cross(wrench.f_P_W)).z() / last;
  }
  held.energy = body.observe().energy;
}

class FemTurningCrank : public ::testing::TestWithParam<TurningBarKind> {};

// Limits: force and energies 0.1 % up to a tenth of a radian per step and 1 % up to a half; torque
// 1e-6 of force times length.
TEST_P(FemTurningCrank, HoldsABarLikewise) {
  const auto& [integrator, formulation, order] = GetParam();
  for (double turn : {0.01, 0.1, 0.3, 0.5}) {
    SCOPED_TRACE(turn);
    Params params = bar(integrator, formulation, order, turn);
    params.initial_velocity = {};
    FlexibleBody body(params);
    const Static expected = centrifugal(body.model(), Crank::shaft());
    const int steps = turn < 0.05 ? 2000 : 600;
    const Crank crank{.ramp = {0.5 * steps * to_seconds(params.micro_step)}};
    Held held;
    hold(body, crank, steps, 0.0, held);
    const bool means = integrator.kind == IntegratorKind::BackwardEuler;
    const double mean = means ? std::sin(0.5 * turn) / (0.5 * turn) : 1.0;
    const double limit = turn < 0.2 ? 1e-3 : 1e-2;
    EXPECT_NEAR(held.turning.x() / (mean * expected.force_N), 1.0, limit);
    EXPECT_LT(std::abs(held.turning.y()), limit * expected.force_N);
    EXPECT_LT(std::abs(held.torque_Nm), 1e-6 * expected.force_N * 4.0);
    EXPECT_NEAR(held.energy.kinetic_J / expected.kinetic_J, 1.0, limit);
    EXPECT_NEAR(held.energy.elastic_J / expected.elastic_J, 1.0, limit);
  }
}

// On averaging ports and on bushings, which give way by m ω² r_c/k.
TEST_P(FemTurningCrank, HoldsAveragingPortsAndBushingsLikewise) {
  const auto& [integrator, formulation, order] = GetParam();
  if (order == 2) return;  // the same recursion
  const bool means = integrator.kind == IntegratorKind::BackwardEuler;
  const double stiffness = 1e9;
  for (const scenario::Attachment& attachment : {averaging(), bushing(stiffness, stiffness)}) {
    for (double turn : {0.1, 0.5}) {
      SCOPED_TRACE(turn);
      const bool gives = attachment.kind == scenario::AttachmentKind::Bushing;
      Params params = bar(integrator, formulation, order, turn);
      params.initial_velocity = {};
      params.ports[0].attachment = attachment;
      params.ports[0].attachment.bushing.damping = 1e6 * scenario::Matrix6::Identity();
      FlexibleBody body(params);
      const Static rigid = centrifugal(body.model(), Crank::shaft());
      double mass = 0.0;
      for (double m : body.model().nodal_mass) mass += m;
      const double softening = mass * kRate_rad_per_s * kRate_rad_per_s / stiffness;
      const double expected_N = rigid.force_N / (gives ? 1.0 - softening : 1.0);
      const int steps = turn < 0.2 ? 2000 : 600;
      const Crank crank{.ramp = {0.5 * steps * to_seconds(params.micro_step)}};
      Held held;
      hold(body, crank, steps, 0.0, held);
      const double mean = means ? std::sin(0.5 * turn) / (0.5 * turn) : 1.0;
      const double limit = turn < 0.2 ? 1e-3 : 1e-2;
      EXPECT_NEAR(held.turning.x() / (mean * expected_N), 1.0, limit) << gives;
      EXPECT_LT(std::abs(held.turning.y()), limit * expected_N) << gives;
      EXPECT_LT(std::abs(held.torque_Nm), 1e-6 * expected_N * 4.0) << gives;
    }
  }
}

// The shaft is accelerated while it turns: the bar then pulls with m a more, in W axes, turning or
// not. Stiffer by a hundred, so that the bending by m a does not show.
TEST_P(FemTurningCrank, IsAcceleratedAsAWhole) {
  const auto& [integrator, formulation, order] = GetParam();
  if (order == 2) return;  // the same recursion
  for (double turn : {0.1, 0.5}) {
    SCOPED_TRACE(turn);
    Params params = bar(integrator, formulation, order, turn);
    params.material.young_Pa *= 100.0;
    params.initial_velocity = {};
    FlexibleBody body(params);
    const Static expected = centrifugal(body.model(), Crank::shaft());
    double mass = 0.0;
    for (double m : body.model().nodal_mass) mass += m;
    const int steps = 600;
    const Crank crank{.ramp = {0.5 * steps * to_seconds(params.micro_step)},
                      .acceleration = {300.0, -200.0, 100.0}};
    const bool means = integrator.kind == IntegratorKind::BackwardEuler;
    const double mean = means ? std::sin(0.5 * turn) / (0.5 * turn) : 1.0;
    Held held;
    hold(body, crank, steps, mean * expected.force_N, held);
    const double expected_N = mass * crank.acceleration.norm();
    EXPECT_LT((held.in_W + mass * crank.acceleration).norm(), 1e-3 * expected_N);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, FemTurningCrank,
    ::testing::Combine(::testing::Values(IntegratorParams{}, kHht, kGeneralised,
                                         IntegratorParams{.kind = IntegratorKind::Newmark}),
                       kFormulations, ::testing::Values(1, 2)));

}  // namespace
}  // namespace tandem::fem
