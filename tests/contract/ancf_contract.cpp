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

/// The Jacobian of a step of 0.5 ms from the last checkpoint against central differences, which
/// have the round-off of wrenches over steps of 1e-8 as part of the Jacobian's norm.
void expect_exact_jacobian(BeamBody& body, const MotionSet& begin, const MotionSet& end,
                           double round_off) {
  const SimTime h(500'000);
  const auto wrench_at = [&](const Eigen::VectorXd& change) {
    body.rollback();
    const auto result = body.advance({.step = h, .input = {begin, displaced(end, change)}});
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
    return stack(result.output);
  };
  const auto linear = body.advance({.step = h, .input = {begin, end}, .linearize = true});
  ASSERT_TRUE(linear.jacobian.has_value());
  ASSERT_GT(stack(linear.output).norm(), 1.0);
  // Translations and rotations by 1e-8, velocities and spins by 1e-5: no point changes its state.
  for (Eigen::Index j = 0; j < linear.jacobian->cols(); ++j) {
    const double step = j % 12 < 6 ? 1e-8 : 1e-5;
    const Eigen::VectorXd d = step * Eigen::VectorXd::Unit(linear.jacobian->cols(), j);
    const Eigen::VectorXd difference = (wrench_at(d) - wrench_at(-d)) / (2.0 * step);
    EXPECT_LT((linear.jacobian->col(j) - difference).norm(),
              1e-5 * difference.norm() + round_off * linear.jacobian->norm())
        << "column " << j;
  }
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
  // Wrenches of 15 N have round-off and Newton errors of 1e-13 N or less.
  expect_exact_jacobian(body, wheel_at(0.01), wheel_at(0.0105), 1e-8);
}

/// The belt on a turning wheel with one end hinged to a body and the other one clamped to another,
/// which shake.
BeamParams held_belt() {
  BeamParams params = belt();
  params.model.mesh.fixed.assign(params.model.mesh.fixed.size(), false);
  params.ports = {"wheel", "first", "second"};
  params.attachments = {{.port = 1, .support = Support::Hinged},
                        {.port = 2, .at_end = true, .support = Support::Clamped}};
  params.step.tolerance_m = 1e-13;
  return params;
}

MotionSet shaken_at(double t) {
  const double a = 20.0 * t;
  Motion first;
  first.p_WP = {-0.02, 0.01, 1e-3 * std::sin(a)};
  first.v_WP = {0.0, 0.0, 0.02 * std::cos(a)};
  first.q_WP = Eigen::AngleAxisd(0.05 * std::sin(a), Eigen::Vector3d::UnitX());
  first.w_WP = {std::cos(a), 0.0, 0.0};
  Motion second;
  second.p_WP = {0.85, 0.0, 1e-3 * (1.0 - std::cos(a))};
  second.v_WP = {0.0, 0.0, 0.02 * std::sin(a)};
  second.q_WP = Eigen::AngleAxisd(0.02 * std::sin(a), Eigen::Vector3d::UnitY());
  second.w_WP = {0.0, 0.4 * std::cos(a), 0.0};
  return {wheel_at(t)[0], first, second};
}

TEST(AncfContract, JacobianOfAttachedEndsIsTheDerivativeOfTheirWrenches) {
  BeamBody body(held_belt());
  body.initialize(shaken_at(0.0));
  const SimTime h(500'000);
  for (int k = 0; k < 20; ++k) {
    const double t = 5e-4 * k;
    ASSERT_EQ(body.advance({.step = h, .input = {shaken_at(t), shaken_at(t + 5e-4)}}).outcome,
              Outcome::Done);
  }
  body.checkpoint();
  EXPECT_GT(body.sums().wheels[0].f_P_W.norm(), 1.0);  // the wheel does touch
  // The round-off of positions of the size of 1 m meets the stiffness of an element itself: some
  // 1e-16 m over the 1e-8 m of a step.
  expect_exact_jacobian(body, shaken_at(0.01), shaken_at(0.0105), 1e-7);
}

TEST(AncfContract, AttachedEndsFollowTheirPortsAndRollBackExactly) {
  BeamBody body(held_belt());
  body.initialize(shaken_at(0.0));
  const SimTime H(1'000'000);
  const auto step = [&](double to) {
    return body.advance({.step = H, .input = {shaken_at(0.0), shaken_at(to)}});
  };
  const auto expected = step(1e-3);
  const Observation after = body.observe();
  body.rollback();
  ASSERT_EQ(step(2e-3).outcome, Outcome::Done);
  body.rollback();
  EXPECT_EQ(stack(step(1e-3).output), stack(expected.output));
  EXPECT_EQ(body.observe().state_hash, after.state_hash);
  // As they lay at t = 0: the tip 0.05 m before the second port, its gradients those of its frame.
  const MotionSet now = shaken_at(1e-3);
  const BeamVectors last = body.system().mesh().gather(7, body.state().q);
  EXPECT_LT((last.col(4) - now[2].p_WP - now[2].q_WP * Eigen::Vector3d(-0.05, 0.0, 0.0)).norm(),
            1e-15);
  EXPECT_LT((last.col(5) - last.col(5).norm() * (now[2].q_WP * Eigen::Vector3d::UnitX())).norm(),
            1e-15);
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
