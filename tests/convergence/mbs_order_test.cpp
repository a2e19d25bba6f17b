// ODE's semi-implicit Euler step against closed forms: first order in h, neither more nor less.
#include "tests/support/mbs_order.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/free_asymmetric_top.h"
#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {
namespace {

TEST(MbsOrder, TorqueFreeAsymmetricTopFollowsTheEllipticSolution) {
  const Eigen::Vector3d moments(1.0, 1.6, 2.2);
  const FreeAsymmetricTop exact(moments, 1.5, 3.0);
  const double duration = 1.0;
  expect_order(1.0, SimTime(8'000'000), [&](SimTime h) {
    Params params = params_with_step(h);
    BodyParams top = body_at("top", 1.0, Eigen::Vector3d::Zero(), moments);
    top.q_WB = exact.attitude(0.0);
    top.w_WB = top.q_WB * exact.angular_velocity_B(0.0);
    params.bodies = {top};
    RigidWorld world(params);
    run(world, h, static_cast<int>(std::lround(duration / to_seconds(h))));
    const BodyState& end = world.state().bodies[0];
    const double attitude_error = end.q_WB.angularDistance(exact.attitude(duration));
    const Eigen::Vector3d w_exact = exact.attitude(duration) * exact.angular_velocity_B(duration);
    return attitude_error + (end.w_WB - w_exact).norm();
  });
}

TEST(MbsOrder, PhysicalPendulumFollowsTheEllipticSolution) {
  expect_order(1.0, SimTime(2'000'000),
               [](SimTime h) { return pendulum_errors(params_with_step(h), h).angle_rad; });
}

/// m ẍ + c ẋ + k x = 0 with x(0) = a, ẋ(0) = 0. The position of a semi-implicit Euler step started
/// with the velocity of t = 0 (instead of −h/2) is of first order.
TEST(MbsOrder, SpringDamperOscillatorIsFirstOrder) {
  const double mass = 2.0, stiffness = 200.0, damping = 2.0, a = 0.1, duration = 1.0;
  const double delta = damping / (2 * mass);
  const double omega = std::sqrt(stiffness / mass - delta * delta);
  const double x_exact = a * std::exp(-delta * duration) *
                         (std::cos(omega * duration) + delta / omega * std::sin(omega * duration));
  expect_order(1.0, SimTime(4'000'000), [&](SimTime h) {
    Params params = params_with_step(h);
    params.bodies = {body_at("mass", mass, {1.0 + a, 0.0, 0.0})};
    params.springs = {{.name = "spring",
                       .body1 = "mass",
                       .body2 = kWorld,
                       .p1_W = {1.0 + a, 0.0, 0.0},
                       .p2_W = Eigen::Vector3d::Zero(),
                       .stiffness_N_per_m = stiffness,
                       .damping_N_s_per_m = damping,
                       .rest_length_m = 1.0}};
    RigidWorld world(params);
    run(world, h, static_cast<int>(std::lround(duration / to_seconds(h))));
    return std::abs(world.state().bodies[0].p_WB.x() - 1.0 - x_exact);
  });
}

/// The same oscillator on the coordinate of a hinge or a slider: I θ̈ + c θ̇ + k (θ − θ0) = 0 from
/// θ = 0 at rest; θ0 = 4 takes a hinge through more than half a turn.
double joint_oscillator_error(SimTime h, JointKind kind, bool between_bodies) {
  const double moment = 0.5, stiffness = 50.0, damping = 0.5, rest = 4.0, duration = 1.0;
  const double delta = damping / (2 * moment);
  const double omega = std::sqrt(stiffness / moment - delta * delta);
  const double theta_exact =
      rest - rest * std::exp(-delta * duration) *
                 (std::cos(omega * duration) + delta / omega * std::sin(omega * duration));
  Params params = params_with_step(h);
  // Between two equal free bodies the reduced mass (moment) is half of each one's.
  const double each = between_bodies ? 2 * moment : moment;
  const Eigen::Vector3d moments = Eigen::Vector3d::Constant(each);
  params.bodies = {body_at("a", each, Eigen::Vector3d::Zero(), moments)};
  if (between_bodies) params.bodies.push_back(body_at("b", each, {0.0, 0.0, 0.0}, moments));
  params.joints = {joint_between("pin", kind, "a", between_bodies ? "b" : kWorld,
                                 Eigen::Vector3d::Zero(), {1.0, 2.0, -1.0})};
  params.joint_springs = {
      {.name = "coil", .joint = "pin", .stiffness = stiffness, .damping = damping, .rest = rest}};
  RigidWorld world(params);
  run(world, h, static_cast<int>(std::lround(duration / to_seconds(h))));
  return std::abs(world.state().joint_coordinates[0][0] - theta_exact);
}

TEST(MbsOrder, JointSpringDamperIsFirstOrder) {
  for (const JointKind kind : {JointKind::Hinge, JointKind::Slider}) {
    for (const bool between_bodies : {false, true}) {
      expect_order(1.0, SimTime(4'000'000),
                   [&](SimTime h) { return joint_oscillator_error(h, kind, between_bodies); });
    }
  }
}

/// Crank of radius r turning at Ω drives a slider along x by a rod of length l:
///   x = r cos θ + √(l² − r² sin² θ).
/// Ball and universal joints close the loop without constraining anything twice, so cfm may be 0.
Params slider_crank(SimTime h, double r, double l, double rate, double erp) {
  Params params = params_with_step(h);
  params.erp = erp;
  BodyParams crank = body_at("crank", 1.0, {0.5 * r, 0.0, 0.0}, {0.01, 0.01, 0.01});
  crank.w_WB = {0.0, 0.0, rate};
  crank.v_WB = {0.0, 0.5 * r * rate, 0.0};
  BodyParams rod = body_at("rod", 1.0, {r + 0.5 * l, 0.0, 0.0}, {0.01, 0.1, 0.1});
  rod.w_WB = {0.0, 0.0, -r * rate / l};
  rod.v_WB = {0.0, 0.5 * r * rate, 0.0};
  params.bodies = {crank, rod, body_at("piston", 1.0, {r + l, 0.0, 0.0})};
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), z = Eigen::Vector3d::UnitZ();
  JointParams drive =
      joint_between("drive", JointKind::Hinge, "crank", kWorld, Eigen::Vector3d::Zero(), z);
  drive.motor = MotorParams{.kind = MotorParams::Kind::Speed, .law = constant(rate)};
  params.joints = {
      drive, joint_between("pin", JointKind::Ball, "rod", "crank", {r, 0.0, 0.0}),
      joint_between("wrist", JointKind::Universal, "rod", "piston", {r + l, 0.0, 0.0}, z,
                    Eigen::Vector3d::UnitY()),
      joint_between("guide", JointKind::Slider, "piston", kWorld, {r + l, 0.0, 0.0}, x)};
  return params;
}

double slider_crank_error(SimTime h, double erp) {
  const double r = 0.2, l = 0.6, rate = 2.0 * std::numbers::pi;
  RigidWorld world(slider_crank(h, r, l, rate, erp));
  double worst = 0.0;
  const int n = static_cast<int>(std::lround(1.0 / to_seconds(h)));
  for (int i = 1; i <= n; ++i) {
    run(world, h, 1);
    const double theta = rate * to_seconds(world.state().time);
    const double x = r * std::cos(theta) + std::sqrt(l * l - std::pow(r * std::sin(theta), 2));
    worst = std::max(worst, std::abs(world.state().bodies[2].p_WB.x() - x));
  }
  return worst;
}

// A step moves a pin along its tangent and misses the circle by ½ r Ω² h², of which the joint
// removes the share erp in the next: a steady error ½ r Ω² h²/erp, of second order in h and inverse
// to erp. (The prescribed crank angle itself is exact.)
TEST(MbsOrder, SliderCrankKeepsItsKinematicsToSecondOrder) {
  expect_order(2.0, SimTime(4'000'000), [](SimTime h) { return slider_crank_error(h, 0.2); });
}

TEST(MbsOrder, SliderCrankErrorIsInverseToErp) {
  const double r = 0.2, rate = 2.0 * std::numbers::pi, h_s = 1e-3;
  for (const double erp : {0.1, 0.2, 0.4, 0.8}) {
    const double steady = 0.5 * r * rate * rate * h_s * h_s / erp;
    const double error = slider_crank_error(kMillisecond, erp);
    // The loop has two pins on circles (crank pin, rod end), so up to twice that of one.
    EXPECT_LT(error, 2.0 * steady) << erp;
    EXPECT_GT(error, 0.5 * steady) << erp;
  }
}

}  // namespace
}  // namespace tandem::mbs::testing
