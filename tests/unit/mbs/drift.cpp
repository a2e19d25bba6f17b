// What the multibody side says of its joints' position error against what a run has.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "mbs_process/joint_drift.h"
#include "mbs_process/joint_gap.h"
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

// The gap that a run reports is the distance that the bodies have, whatever turns meanwhile.
TEST(MbsDrift, GapIsTheDistanceOfTheTwoHalves) {
  const double rate = 6.0 * std::numbers::pi;
  Params params = crank_with_block({.kind = MotorParams::Kind::Speed, .law = constant(rate)}, 0.2);
  RigidWorld world(params);
  EXPECT_EQ(world.observe().widest_joint.joint, -1);
  run(world, kMillisecond, 200);
  const auto& bodies = world.state().bodies;
  const Eigen::Vector3d pin = bodies[0].p_WB + bodies[0].q_WB * Eigen::Vector3d(0.1, 0.0, 0.0);
  const double apart_m = (bodies[1].p_WB - pin).norm();
  const JointGap found = world.observe().widest_joint;
  EXPECT_EQ(found.joint, 1);
  EXPECT_NEAR(found.gap_m, apart_m, 1e-15);
  EXPECT_NEAR(found.part, apart_m / 0.1, 1e-14);
}

// Every kind of joint, its second body displaced and turned by hand: a slider may move along its
// axis, which turns with its first body.
TEST(MbsDrift, GapOfEveryKindOfJoint) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, -1.0).normalized();
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(2.0, -1.0, 3.0).normalized()));
  const Eigen::Vector3d away(0.3, -0.2, 0.5);
  for (const JointKind kind : {JointKind::Ball, JointKind::Hinge, JointKind::Universal,
                               JointKind::Hinge2, JointKind::Fixed, JointKind::Slider}) {
    Params params = params_with_step(kMillisecond);
    params.bodies = {body_at("first", 1.0, {0.1, 0.2, 0.3}),
                     body_at("second", 1.0, {0.6, 0.2, 0.3})};
    params.joints = {joint_between("joint", kind, "first", "second", {0.4, 0.2, 0.3}, axis)};
    params.joints[0].axis2_W = axis.unitOrthogonal();
    const JointGaps gaps(params);
    State state = initial_state(params);
    // Both as one rigid body: no gap.
    for (BodyState& body : state.bodies) {
      body.p_WB = away + turn * body.p_WB;
      body.q_WB = turn;
    }
    EXPECT_LT(gaps.widest(state).gap_m, 1e-15);
    const Eigen::Vector3d d(1e-3, 2e-3, 4e-3);
    state.bodies[1].p_WB += d;
    const Eigen::Vector3d across = d - (turn * axis).dot(d) * (turn * axis);
    const double gap_m = kind == JointKind::Slider ? across.norm() : d.norm();
    const bool centred = kind == JointKind::Slider || kind == JointKind::Fixed;
    EXPECT_NEAR(gaps.widest(state).gap_m, gap_m, 1e-15);
    EXPECT_NEAR(gaps.widest(state).part, gap_m / (centred ? 0.5 : 0.3), 1e-13);
    EXPECT_EQ(gaps.widest(state).joint, 0);
  }
}

}  // namespace
}  // namespace tandem::mbs::testing
