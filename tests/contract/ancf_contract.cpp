#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "fem_process/ancf/beam_body.h"
#include "protocol/contract/error.h"
#include "tests/support/ancf_support.h"

namespace tandem::fem::ancf {
namespace {

/// A belt of eight elements, clamped at one end, that a turning wheel presses up and drags.
BeamParams belt() {
  BeamParams params;
  params.model = testing::straight_beam(0.8, 8, {0.1, 0.01}, testing::track_rubber());
  params.model.gravity_m_per_s2 = {0.0, 0.0, -9.81};
  params.ports = {"wheel"};
  params.wheels = {{.port = 0,
                    .radius_m = 0.1,
                    .contact = {.stiffness_N_per_m3 = 1e7,
                                .damping_N_s_per_m3 = 1e3,
                                .friction = 0.5,
                                .friction_slope_N_s_per_m3 = 1e5}}};
  params.micro_step = SimTime(500'000);
  return params;
}

MotionSet wheel_at(double t) {
  Motion wheel;
  wheel.p_WP = {0.5, 0.0, -0.107 + 0.02 * std::sin(20.0 * t)};
  wheel.v_WP = {0.0, 0.0, 0.4 * std::cos(20.0 * t)};
  wheel.q_WP = Eigen::AngleAxisd(5.0 * t, Eigen::Vector3d::UnitY());
  wheel.w_WP = {0.0, 5.0, 0.0};
  return {wheel};
}

StepRequest<MotionSet> request(double from, double to, SimTime H) {
  return {.step = H, .input = {wheel_at(from), wheel_at(to)}};
}

TEST(AncfContract, RepeatedStepsGiveTheBitsOfASingleOne) {
  BeamBody once(belt());
  BeamBody repeated(belt());
  once.initialize(wheel_at(0.0));
  repeated.initialize(wheel_at(0.0));
  const SimTime H(1'000'000);  // two micro steps
  double largest = 0.0;
  for (int k = 0; k < 60; ++k) {
    const double t = 1e-3 * k;
    once.checkpoint();
    repeated.checkpoint();
    const auto expected = once.advance(request(t, t + 1e-3, H));
    ASSERT_EQ(expected.outcome, Outcome::Done) << expected.message;
    // Other inputs in between: other iterates, other step matrices.
    ASSERT_EQ(repeated.advance(request(t, t + 2e-3, H)).outcome, Outcome::Done);
    repeated.rollback();
    ASSERT_EQ(repeated.advance(request(t, t + 5e-4, H)).outcome, Outcome::Done);
    repeated.rollback();
    const auto found = repeated.advance(request(t, t + 1e-3, H));
    EXPECT_EQ(stack(found.output), stack(expected.output)) << k;
    EXPECT_EQ(repeated.observe().state_hash, once.observe().state_hash) << k;
    largest = std::max(largest, stack(found.output).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(largest, 1.0);  // the wheel did touch
}

TEST(AncfContract, RollbackRestoresEveryBitAndTheClock) {
  BeamBody body(belt());
  body.initialize(wheel_at(0.0));
  body.advance(request(0.0, 1e-3, SimTime(1'000'000)));
  body.checkpoint();
  const Observation saved = body.observe();
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(body.advance(request(1e-3, 3e-3, SimTime(2'000'000))).outcome, Outcome::Done);
    EXPECT_NE(body.observe().state_hash, saved.state_hash);
    body.rollback();
    EXPECT_EQ(body.observe().state_hash, saved.state_hash);
    EXPECT_EQ(body.observe().time, saved.time);
  }
}

TEST(AncfContract, ManyStepsEndExactlyAtTheirSum) {
  BeamBody body(belt());
  body.initialize(wheel_at(0.0));
  for (int k = 0; k < 10; ++k) {
    const double t = 1.5e-3 * k;
    ASSERT_EQ(body.advance(request(t, t + 1.5e-3, SimTime(1'500'000))).outcome, Outcome::Done);
  }
  EXPECT_EQ(body.observe().time, SimTime(15'000'000));
}

TEST(AncfContract, JacobianIsTheDerivativeOfTheWrench) {
  BeamParams params = belt();
  params.step.tolerance_m = 1e-13;
  BeamBody body(params);
  body.initialize(wheel_at(0.0));
  for (int k = 0; k < 20; ++k) {  // into contact
    const double t = 5e-4 * k;
    ASSERT_EQ(body.advance(request(t, t + 5e-4, SimTime(500'000))).outcome, Outcome::Done);
  }
  body.checkpoint();
  const MotionSet begin = wheel_at(0.01);
  const MotionSet end = wheel_at(0.0105);
  const auto wrench_at = [&](const Eigen::Matrix<double, 12, 1>& change) {
    MotionSet moved = end;
    moved[0].p_WP += change.segment<3>(0);
    const Eigen::Vector3d turn = change.segment<3>(3);
    if (turn.norm() > 0.0) {
      moved[0].q_WP = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * moved[0].q_WP;
    }
    moved[0].v_WP += change.segment<3>(6);
    moved[0].w_WP += change.segment<3>(9);
    body.rollback();
    const auto result = body.advance({.step = SimTime(500'000), .input = {begin, moved}});
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
    return stack(result.output);
  };
  const auto linear =
      body.advance({.step = SimTime(500'000), .input = {begin, end}, .linearize = true});
  ASSERT_TRUE(linear.jacobian.has_value());
  ASSERT_GT(stack(linear.output).norm(), 1.0);
  Eigen::MatrixXd differences(6, 12);
  // Translations and rotations by 1e-8, velocities and spins by 1e-5: no point changes its state.
  for (Eigen::Index j = 0; j < 12; ++j) {
    const double step = j < 6 ? 1e-8 : 1e-5;
    const Eigen::Matrix<double, 12, 1> d = step * Eigen::Matrix<double, 12, 1>::Unit(j);
    differences.col(j) = (wrench_at(d) - wrench_at(-d)) / (2.0 * step);
    // Wrenches of 15 N have round-off and Newton errors of 1e-13 N or less over steps of 1e-8.
    EXPECT_LT((linear.jacobian->col(j) - differences.col(j)).norm(),
              1e-5 * differences.col(j).norm() + 1e-8 * linear.jacobian->norm())
        << "column " << j;
  }
}

TEST(AncfContract, WhatFailsLeavesTheStateAndNamesCauseAndRemedy) {
  BeamParams impatient = belt();
  impatient.step.newton_steps = 2;
  impatient.step.halvings = 1;
  BeamBody body(impatient);
  body.initialize(wheel_at(0.0));
  const Observation before = body.observe();
  MotionSet far = wheel_at(0.0);
  far[0].p_WP.z() += 0.03;
  const auto result = body.advance({.step = SimTime(500'000), .input = {wheel_at(0.0), far}});
  EXPECT_EQ(result.outcome, Outcome::Failed);
  EXPECT_NE(result.message.find("Newton's iteration stalled"), std::string::npos) << result.message;
  EXPECT_NE(result.message.find("Shorten run.macro_step_s"), std::string::npos) << result.message;
  EXPECT_EQ(body.observe().state_hash, before.state_hash);
  MotionSet lost = wheel_at(0.0);
  lost[0].p_WP.x() = std::nan("");
  const auto refused = body.advance({.step = SimTime(500'000), .input = {wheel_at(0.0), lost}});
  EXPECT_EQ(refused.outcome, Outcome::Failed);
  EXPECT_NE(refused.message.find("not finite"), std::string::npos);
}

TEST(AncfContract, AWheelInsideTheBandIsRefused) {
  BeamBody body(belt());
  MotionSet inside = wheel_at(0.0);
  inside[0].p_WP.z() = -0.08;
  try {
    body.initialize(inside);
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    EXPECT_NE(std::string(error.what()).find("port 'wheel'"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("Move its body"), std::string::npos);
  }
}

}  // namespace
}  // namespace tandem::fem::ancf
