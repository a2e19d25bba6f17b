// Soft joints and stops (cfm): J v⁺ + cfm μ = −(erp / h) φ is a spring k = erp/(h cfm) with a
// damper c = (1 − erp)/cfm, with either integrator.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/mbs_coordinate.h"
#include "tests/support/mbs_order.h"

namespace tandem::mbs::testing {
namespace {

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kZ = Eigen::Vector3d::UnitZ();

/// Two bodies in one place on the tested joint and a fixed one to the world, each of which lets the
/// load along z sag.
Params hung_on(JointKind kind, IntegratorKind integrator, double cfm) {
  Params params = params_with_step(10 * kMillisecond);
  params.integrator = integrator;
  params.cfm = cfm;
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  params.bodies = {body_at("a", 1.0, none), body_at("b", 2.0, none)};
  const bool one_axis = kind == JointKind::Hinge || kind == JointKind::Slider;
  const bool two_axes = kind == JointKind::Universal || kind == JointKind::Hinge2;
  // A hinge2 carries the load by its suspension, along axis 1.
  params.joints = {joint_between("tested", kind, "a", "b", none,
                                 two_axes ? kZ : (one_axis ? kX : none), two_axes ? kX : none),
                   joint_between("ground", JointKind::Fixed, "b", kWorld, none)};
  params.ports = {port_on("port", "a")};
  return params;
}

// At rest v⁺ = 0 and μ = F: each joint has given way by φ = cfm F h/erp.
TEST(MbsSoftness, JointsSagByCfmTimesForceAndStepOverErpAndRest) {
  const double force = 10.0, h_s = 1e-2;
  for (const JointKind kind : {JointKind::Ball, JointKind::Hinge, JointKind::Slider,
                               JointKind::Universal, JointKind::Fixed, JointKind::Hinge2}) {
    for (const IntegratorKind integrator : kIntegrators) {
      for (const double cfm : {1e-2, 1e-3, 1e-5}) {
        for (const double erp : {0.2, 0.8}) {
          SCOPED_TRACE(name_of(kind) + text_of({kind, 1}, integrator));
          Params params = hung_on(kind, integrator, cfm);
          params.erp = erp;
          RigidWorld world(params);
          WrenchSet load(1);
          load[0].f_P_W.z() = -force;
          run(world, 10 * kMillisecond, 3000, load);
          const double sag = cfm * force * h_s / erp;
          EXPECT_NEAR(world.state().bodies[0].p_WB.z(), -2.0 * sag, 1e-9 * sag);
          EXPECT_NEAR(world.state().bodies[1].p_WB.z(), -sag, 1e-9 * sag);
          EXPECT_LT(world.state().bodies[0].v_WB.norm(), 1e-9 * sag / h_s);
        }
      }
    }
  }
}

TEST(MbsSoftness, StopsSagLikeJoints) {
  const double effort = 10.0, h_s = 1e-3, cfm = 1e-3, erp = 0.2;
  for (const Coordinate& tested :
       {Coordinate{JointKind::Hinge, 1}, Coordinate{JointKind::Slider, 1},
        Coordinate{JointKind::Universal, 2}}) {
    for (const IntegratorKind integrator : kIntegrators) {
      SCOPED_TRACE(text_of(tested, integrator));
      Params params = body_on(tested, integrator, kMillisecond);
      params.cfm = cfm;
      params.joints[0].limits = {{.axis = tested.axis, .lower = -0.2, .upper = 0.2}};
      RigidWorld world(params);
      run(world, kMillisecond, 5000, effort_on(tested, effort));
      const double sag = cfm * effort * h_s / erp;
      EXPECT_NEAR(coordinate_of(world, tested), 0.2 + sag, 1e-8 * sag);
      EXPECT_NEAR(rate_of(world, tested), 0.0, 1e-8 * sag / h_s);
    }
  }
}

// At the default cfm nothing is seen of it: each joint is at rest to 5e-9 of what its load would do
// to the lightest body in a step.
TEST(MbsSoftness, ABodyRestsOnAJointOfDefaultSoftness) {
  for (const IntegratorKind integrator : kIntegrators) {
    Params params = hung_on(JointKind::Ball, integrator, Params{}.cfm);
    params.gravity_m_per_s2 = {0.0, 0.0, -10.0};
    RigidWorld world(params);
    run(world, 10 * kMillisecond, 500, WrenchSet(1));
    const double ball_N = 10.0, ground_N = 30.0, h_s = 1e-2;
    EXPECT_LT(world.state().bodies[0].v_WB.norm(), 5.01e-9 * (ball_N + ground_N) / 1.0 * h_s);
  }
}

/// Largest distance from m ẍ + c ẋ + k x = 0, x(0) = 0, ẋ(0) = v0, on a ball joint whose erp and
/// cfm are chosen for k and c at the step h.
double soft_ball_error(IntegratorKind integrator, SimTime h) {
  const double mass = 1.0, k = 100.0, c = 2.0, v0 = 1.0;
  const double h_s = to_seconds(h);
  Params params = params_with_step(h);
  params.integrator = integrator;
  params.erp = h_s * k / (h_s * k + c);
  params.cfm = 1.0 / (h_s * k + c);
  params.bodies = {body_at("ball", mass, Eigen::Vector3d::Zero())};
  params.bodies[0].v_WB.y() = v0;
  params.joints = {
      joint_between("rubber", JointKind::Ball, "ball", kWorld, Eigen::Vector3d::Zero())};
  RigidWorld world(params);
  const double delta = c / (2 * mass), omega = std::sqrt(k / mass - delta * delta);
  double largest = 0.0;
  const int n = static_cast<int>(std::lround(1.0 / h_s));
  for (int i = 1; i <= n; ++i) {
    run(world, h, 1);
    const double t = i * h_s;
    const double x = v0 / omega * std::exp(-delta * t) * std::sin(omega * t);
    largest = std::max(largest, std::abs(world.state().bodies[0].p_WB.y() - x));
  }
  return largest;
}

// The spring is taken at the end of the step, which is of first order.
TEST(MbsSoftness, ASoftJointIsASpringAndDamper) {
  for (const IntegratorKind integrator : kIntegrators) {
    expect_order(1.0, kMillisecond, [&](SimTime h) { return soft_ball_error(integrator, h); });
    // Euler's implicit spring damps like h k more, Verlet's like half of that: δ is larger by
    // h k/(2 m) = 0.025/s, and the amplitude v0/ω · t exp(−δ t) times that smaller, 9e-4 m at most.
    EXPECT_LT(soft_ball_error(integrator, kMillisecond / 2), 1e-3);
  }
}

// Whatever the softness, doubly constrained motions stay solvable: a wheel on two hinges in line.
TEST(MbsSoftness, TwoHingesInLineCarryOneWheel) {
  for (const IntegratorKind integrator : kIntegrators) {
    for (const double cfm : {1e-10, 1e-8, 1e-6, 1e-4}) {
      Params params = params_with_step(kMillisecond);
      params.integrator = integrator;
      params.cfm = cfm;
      params.gravity_m_per_s2 = {0.0, 0.0, -10.0};
      params.bodies = {body_at("wheel", 1.0, Eigen::Vector3d::Zero())};
      params.bodies[0].w_WB = {0.0, 20.0, 0.0};
      params.joints = {
          joint_between("left", JointKind::Hinge, "wheel", kWorld, {0.0, -0.2, 0.0}, kY),
          joint_between("right", JointKind::Hinge, "wheel", kWorld, {0.0, 0.2, 0.0}, kY)};
      RigidWorld world(params);
      run(world, kMillisecond, 1000);
      const BodyState& wheel = world.state().bodies[0];
      EXPECT_NEAR(wheel.w_WB.y(), 20.0, 1e-9);
      EXPECT_NEAR(wheel.p_WB.z(), -cfm * 5.0 * 1e-3 / params.erp, 1e-8 * std::sqrt(cfm));
    }
  }
}

}  // namespace
}  // namespace tandem::mbs::testing
