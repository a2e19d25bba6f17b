// What the multibody side says of its joints' position error against what a run has.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "mbs_process/joint_drift.h"
#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {
namespace {

/// A crank of 0.1 m that turns about y, with a block on its pin.
Params crank_with_block(const MotorParams& motor, double erp) {
  Params params = params_with_step(kMillisecond);
  params.erp = erp;
  params.bodies = {body_at("crank", 1.0, Eigen::Vector3d::Zero()),
                   body_at("block", 0.1, {0.1, 0.0, 0.0}, {1e-4, 1e-4, 1e-4})};
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  params.joints = {
      joint_between("shaft", JointKind::Hinge, "crank", kWorld, Eigen::Vector3d::Zero(), y),
      joint_between("pin", JointKind::Hinge, "block", "crank", {0.1, 0.0, 0.0}, y)};
  params.joints[0].motor = motor;
  return params;
}

/// Distance of the block from its pin after 0.2 s.
double measured_error(const Params& params) {
  RigidWorld world(params);
  run(world, kMillisecond, 200);
  const auto& bodies = world.state().bodies;
  const Eigen::Vector3d pin = bodies[0].p_WB + bodies[0].q_WB * Eigen::Vector3d(0.1, 0.0, 0.0);
  return (bodies[1].p_WB - pin).norm();
}

TEST(MbsDrift, EstimateIsWhatASteadyCrankHas) {
  const double rate = 6.0 * std::numbers::pi;
  for (const IntegratorKind integrator : {IntegratorKind::Euler, IntegratorKind::Verlet}) {
    for (const double erp : {0.1, 0.2, 0.8}) {
      Params params =
          crank_with_block({.kind = MotorParams::Kind::Speed, .law = constant(rate)}, erp);
      params.integrator = integrator;
      const JointDrift found = joint_drift(params, 0.2);
      EXPECT_EQ(found.joint, "pin");
      EXPECT_NEAR(found.error_m, 0.5 * 1e-6 * rate * rate * 0.1 / erp, 1e-18);
      // To h w/erp: the error turns with the crank while it is removed.
      EXPECT_NEAR(measured_error(params), found.error_m, 1e-3 * rate / erp * found.error_m);
    }
  }
}

TEST(MbsDrift, LargestRateOfALawCounts) {
  const auto rate_found = [](const MotorParams& motor) {
    return joint_drift(crank_with_block(motor, 0.2), 1.0).rate_rad_per_s;
  };
  EXPECT_NEAR(
      rate_found({.kind = MotorParams::Kind::Speed, .law = Law(RampLaw{0.0, 0.3, 0.0, 8.0})}), 8.0,
      1e-12);
  // a sin(2π f t): 2π f a, and the mean over the step from its top on, (2π f h)²/6 less.
  const MotorParams swing{.kind = MotorParams::Kind::Position,
                          .law = Law(HarmonicLaw{0.0, 0.5, 2.0})};
  EXPECT_NEAR(rate_found(swing), 2.0 * std::numbers::pi, 2e-4);
}

TEST(MbsDrift, WarnsOfArmsThatAreOffByMoreThanAShare) {
  const auto warning = [](double rate) {
    return drift_warning(
        crank_with_block({.kind = MotorParams::Kind::Speed, .law = constant(rate)}, 0.2), 1.0);
  };
  // (h w)²/(2 erp) = 5e-4 at w = 14.14 rad/s.
  EXPECT_FALSE(warning(14.1));
  ASSERT_TRUE(warning(14.2));
  EXPECT_NE(warning(6.0 * std::numbers::pi)->find("joint 'pin' will be off by about 8.88e-05 m"),
            std::string::npos);
}

}  // namespace
}  // namespace tandem::mbs::testing
