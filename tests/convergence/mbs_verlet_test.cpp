// Velocity Verlet on ODE's steps against closed forms: second order in poses and velocities.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/free_asymmetric_top.h"
#include "tests/support/mbs_mechanisms.h"
#include "tests/support/mbs_order.h"

namespace tandem::mbs::testing {
namespace {

Params verlet_params(SimTime h) {
  Params params = params_with_step(h);
  params.integrator = IntegratorKind::Verlet;
  return params;
}

int steps_of(double duration_s, SimTime h) {
  return static_cast<int>(std::lround(duration_s / to_seconds(h)));
}

TEST(MbsVerlet, TorqueFreeAsymmetricTopFollowsTheEllipticSolution) {
  const Eigen::Vector3d moments(1.0, 1.6, 2.2);
  const FreeAsymmetricTop exact(moments, 1.5, 3.0);
  const double duration = 1.0;
  expect_order(2.0, SimTime(8'000'000), [&](SimTime h) {
    Params params = verlet_params(h);
    BodyParams top = body_at("top", 1.0, Eigen::Vector3d::Zero(), moments);
    top.q_WB = exact.attitude(0.0);
    top.w_WB = top.q_WB * exact.angular_velocity_B(0.0);
    params.bodies = {top};
    RigidWorld world(params);
    run(world, h, steps_of(duration, h));
    const BodyState& end = world.state().bodies[0];
    const Eigen::Vector3d w_exact = exact.attitude(duration) * exact.angular_velocity_B(duration);
    return end.q_WB.angularDistance(exact.attitude(duration)) + (end.w_WB - w_exact).norm();
  });
}

TEST(MbsVerlet, PhysicalPendulumIsOfSecondOrderInAngleAndVelocity) {
  const auto errors = [](SimTime h) { return pendulum_errors(verlet_params(h), h); };
  expect_order(2.0, SimTime(1'000'000), [&](SimTime h) { return errors(h).angle_rad; });
  expect_order(2.0, SimTime(1'000'000), [&](SimTime h) { return errors(h).speed_m_per_s; });
}

/// m ẍ + c ẋ + k x = f sin(Ω t) with x(0) = a, ẋ(0) = 0, as two free vibrations and one forced one.
TEST(MbsVerlet, DrivenSpringDamperOscillatorIsOfSecondOrderInPositionAndVelocity) {
  const double mass = 2.0, stiffness = 200.0, damping = 2.0, a = 0.1, duration = 1.0;
  const double force = 5.0, rate = 7.0;
  const double delta = damping / (2 * mass), omega2 = stiffness / mass;
  const double omega = std::sqrt(omega2 - delta * delta);
  // Forced part A sin Ωt + B cos Ωt.
  const double real = omega2 - rate * rate, imaginary = 2 * delta * rate;
  const double scale = force / mass / (real * real + imaginary * imaginary);
  const double A = scale * real, B = -scale * imaginary;
  const double c = a - B, s = (-A * rate + delta * c) / omega;
  const auto x_exact = [&](double t) {
    return std::exp(-delta * t) * (c * std::cos(omega * t) + s * std::sin(omega * t)) +
           A * std::sin(rate * t) + B * std::cos(rate * t);
  };
  // Central difference of the closed form: 1e-10 relative.
  const double v_exact = (x_exact(duration + 1e-5) - x_exact(duration - 1e-5)) / 2e-5;
  for (const bool velocity : {false, true}) {
    expect_order(2.0, SimTime(4'000'000), [&](SimTime h) {
      Params params = verlet_params(h);
      params.bodies = {body_at("mass", mass, {1.0 + a, 0.0, 0.0})};
      params.springs = {{.name = "spring",
                         .body1 = "mass",
                         .body2 = kWorld,
                         .p1_W = {1.0 + a, 0.0, 0.0},
                         .p2_W = Eigen::Vector3d::Zero(),
                         .stiffness_N_per_m = stiffness,
                         .damping_N_s_per_m = damping,
                         .rest_length_m = 1.0}};
      ForceParams drive{.name = "drive", .body = "mass"};
      drive.direction_W = Eigen::Vector3d::UnitX();
      drive.law = Law(HarmonicLaw{.amplitude = force, .frequency_Hz = rate / (2.0 * M_PI)});
      params.forces = {drive};
      RigidWorld world(params);
      run(world, h, steps_of(duration, h));
      const BodyState& end = world.state().bodies[0];
      return velocity ? std::abs(end.v_WB.x() - v_exact)
                      : std::abs(end.p_WB.x() - 1.0 - x_exact(duration));
    });
  }
}

// A free body under port wrenches moves by Newmark's rule, exactly.
TEST(MbsVerlet, FreeBodyFollowsNewmarksRule) {
  for (double beta : {0.0, 1.0 / 12.0, 0.25}) {
    Params params = verlet_params(kMillisecond);
    params.newmark_beta = beta;
    params.bodies = {body_at("body", 2.0, Eigen::Vector3d::Zero())};
    params.ports = {port_on("p", "body")};
    RigidWorld world(params);
    WrenchSet begin(1), end(1);
    begin[0].f_P_W = {1.0, 2.0, -3.0};
    end[0].f_P_W = {5.0, -2.0, 0.5};
    ASSERT_EQ(world.advance(step_of(kMillisecond, begin, end)).outcome, Outcome::Done);
    const Eigen::Vector3d a = begin[0].f_P_W / 2.0, a_end = end[0].f_P_W / 2.0;
    const Eigen::Vector3d v = 0.5e-3 * (a + a_end);
    const Eigen::Vector3d p = 1e-6 * ((0.5 - beta) * a + beta * a_end);
    // A few roundings of numbers of these sizes.
    EXPECT_LT((world.state().bodies[0].v_WB - v).norm(), 1e-17);
    EXPECT_LT((world.state().bodies[0].p_WB - p).norm(), 1e-20);
  }
}

/// Velocities (m/s) and rates (rad/s) that the kind of joint forbids, between an arm that swings on
/// a ball and a bob at its end: the largest over the steps.
double forbidden_velocity(JointKind kind) {
  Params params = verlet_params(kMillisecond);
  params.gravity_m_per_s2 = {0.0, 0.0, -9.81};
  const Eigen::Vector3d tip(0.4, 0.0, 0.0);
  params.bodies = {body_at("arm", 1.0, {0.2, 0.0, 0.0}, {0.01, 0.02, 0.03}),
                   body_at("bob", 2.0, {0.6, 0.1, 0.0}, {0.03, 0.02, 0.01})};
  const Eigen::Vector3d w(0.0, 3.0, 5.0);
  for (BodyParams& body : params.bodies) {
    body.w_WB = w;
    body.v_WB = w.cross(body.p_WB);
  }
  const bool one_axis = kind == JointKind::Hinge;
  const bool two_axes = kind == JointKind::Universal || kind == JointKind::Hinge2;
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  params.joints = {joint_between("root", JointKind::Ball, "arm", kWorld, none),
                   joint_between("tip", kind, "bob", "arm", tip,
                                 one_axis || two_axes ? Eigen::Vector3d::UnitZ().eval() : none,
                                 two_axes ? Eigen::Vector3d::UnitX().eval() : none)};
  RigidWorld world(params);
  double largest = 0.0;
  const auto velocity_at = [&](std::size_t i, const Eigen::Vector3d& p_W) {
    const BodyState& body = world.state().bodies[i];
    return Eigen::Vector3d(body.v_WB + body.w_WB.cross(body.q_WB * (p_W - params.bodies[i].p_WB)));
  };
  for (int i = 0; i < 100; ++i) {
    run(world, kMillisecond, 1);
    largest = std::max(largest, velocity_at(0, Eigen::Vector3d::Zero()).norm());
    largest = std::max(largest, (velocity_at(0, tip) - velocity_at(1, tip)).norm());
    if (kind == JointKind::Fixed) {
      const auto& bodies = world.state().bodies;
      largest = std::max(largest, (bodies[0].w_WB - bodies[1].w_WB).norm());
    }
  }
  return largest;
}

// J(x⁺) v⁺ = 0 at the end of every step, to round-off of velocities of 4 m/s: a joint that went on
// removing its position error there would leave a velocity of the size h w² r/2, of first order.
TEST(MbsVerlet, JointsHoldTheVelocitiesAtTheEndOfAStep) {
  for (JointKind kind : {JointKind::Ball, JointKind::Hinge, JointKind::Universal, JointKind::Hinge2,
                         JointKind::Fixed}) {
    EXPECT_LT(forbidden_velocity(kind), 1e-12) << static_cast<int>(kind);
  }
}

// Energy booked: what a force law and a motor put in is what the bodies gain, to the integrator's
// own second-order error.
TEST(MbsVerlet, BooksTheWorkOfAForce) {
  Params params = verlet_params(kMillisecond);
  params.bodies = {body_at("body", 2.0, Eigen::Vector3d::Zero())};
  ForceParams push{.name = "push", .body = "body"};
  push.direction_W = Eigen::Vector3d::UnitX();
  push.law = constant(3.0);
  params.forces = {push};
  RigidWorld world(params);
  run(world, kMillisecond, 100);
  const EnergyBook energy = world.observe().energy;
  // ½ m v² of v = 0.15 m/s is 0.0225 J; the sum of 100 steps rounds to 1e-15 of it each.
  EXPECT_NEAR(energy.kinetic_J, 0.0225, 1e-14);
  EXPECT_NEAR(energy.external_work_J, energy.kinetic_J, 1e-14);
}

// A linearised step is affine in the wrenches: the Jacobian predicts another wrench's motion.
TEST(MbsVerlet, JacobianIsThatOfTheStep) {
  Params params = verlet_params(kMillisecond);
  params.bodies = {body_at("bob", 2.0, {0.5, 0.0, 0.0}, {0.1, 0.2, 0.3})};
  params.joints = {joint_between("pivot", JointKind::Ball, "bob", kWorld, Eigen::Vector3d::Zero())};
  params.ports = {port_on("p", "bob")};
  RigidWorld world(params);
  world.checkpoint();
  const WrenchSet zero(1);
  WrenchSet pushed(1);
  pushed[0] = {.f_P_W = {1.0, 2.0, 3.0}, .t_P_W = {0.1, -0.2, 0.3}};
  StepRequest<WrenchSet> request = step_of(kMillisecond, zero, zero);
  request.linearize = true;
  const auto base = world.advance(request);
  world.rollback();
  const auto other = world.advance(step_of(kMillisecond, zero, pushed));
  const Eigen::VectorXd change = difference(base.output, other.output);
  const Eigen::VectorXd predicted = base.jacobian.value() * stack(pushed);
  // The pose is linear to the product of angle and displacement, 1e-6 of each other here.
  EXPECT_LT((change - predicted).norm(), 1e-5 * change.norm());
}

}  // namespace
}  // namespace tandem::mbs::testing
