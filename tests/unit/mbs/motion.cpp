// The multibody side against laws of mechanics that its step obeys exactly or to a known order.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {
namespace {

const Eigen::Vector3d kZ = Eigen::Vector3d::UnitZ();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// A wheel on a hinge (or slider) along z through its centre, driven as told.
Params driven_wheel(const MotorParams& motor, JointKind kind = JointKind::Hinge) {
  Params params = params_with_step(kMillisecond);
  params.bodies = {body_at("wheel", 1.0, Eigen::Vector3d::Zero(), {0.1, 0.1, 0.2})};
  JointParams hinge = joint_between("axle", kind, "wheel", kWorld, Eigen::Vector3d::Zero(), kZ);
  hinge.motor = motor;
  params.joints = {hinge};
  params.ports = {port_on("port", "wheel")};
  return params;
}

double coordinate_of(const RigidWorld& world) { return world.state().joint_coordinates[0][0]; }

// z_n = −g h² n (n + 1) / 2: the exact sum of the semi-implicit Euler step.
TEST(MbsMotion, FreeFallIsTheSumOfSemiImplicitEuler) {
  Params params = params_with_step(kMillisecond);
  params.gravity_m_per_s2 = {0.0, 0.0, -9.81};
  params.bodies = {body_at("stone", 3.0, Eigen::Vector3d::Zero())};
  RigidWorld world(params);
  const int n = 1000;
  run(world, kMillisecond, n);
  const double z = -9.81 * 1e-6 * n * (n + 1) / 2;
  // n additions, each rounded to half an ulp of at most |z|; ODE multiplies h m g by 1/m.
  EXPECT_NEAR(world.state().bodies[0].p_WB.z(), z, n * kEpsilon * std::abs(z));
  EXPECT_EQ(world.state().bodies[0].p_WB.x(), 0.0);
}

// The pose is turned by the finite rotation exp(h w×): 50 mrad steps about a fixed axis add up
// exactly. (ODE's default, a step of the quaternion's rate, would be off by (h w)³/12 each: 10
// mrad.)
TEST(MbsMotion, SteadySpinIsExactAtAnyStep) {
  Params params = params_with_step(kMillisecond);
  BodyParams ball = body_at("ball", 1.0, Eigen::Vector3d::Zero());
  ball.w_WB = Eigen::Vector3d(3.0, -4.0, 12.0).normalized() * 50.0;
  params.bodies = {ball};
  RigidWorld world(params);
  const int n = 1000;
  run(world, kMillisecond, n);
  const BodyState& end = world.state().bodies[0];
  EXPECT_LT((end.w_WB - ball.w_WB).norm(), n * kEpsilon * 50.0);
  const Eigen::Quaterniond exact(Eigen::AngleAxisd(50.0, ball.w_WB.normalized()));
  EXPECT_LT(end.q_WB.angularDistance(exact), n * 8 * kEpsilon);
}

TEST(MbsMotion, OppositePortForcesKeepTheMomentumOfFreeBodies) {
  Params params = params_with_step(kMillisecond);
  BodyParams a = body_at("a", 2.0, {0.0, 0.0, 0.0});
  BodyParams b = body_at("b", 3.0, {1.0, 0.5, 0.0});
  a.v_WB = {1.0, 2.0, 3.0};
  b.v_WB = {-2.0, 1.0, 0.0};
  params.bodies = {a, b};
  params.ports = {port_on("pa", "a"), port_at("pb", "b", {0.0, 0.0, 0.0})};
  RigidWorld world(params);
  const auto momentum = [&world] {
    return Eigen::Vector3d(2.0 * world.state().bodies[0].v_WB + 3.0 * world.state().bodies[1].v_WB);
  };
  const Eigen::Vector3d before = momentum();
  const int n = 1000;
  for (int i = 0; i < n; ++i) {
    WrenchSet wrenches(2);
    wrenches[0].f_P_W = {100 * std::sin(0.1 * i), -30.0, 20.0 * i};
    wrenches[1].f_P_W = -wrenches[0].f_P_W;
    run(world, kMillisecond, 1, wrenches);
  }
  // The largest momentum reached is 1e4 N · 1 s; each step rounds it twice per body.
  EXPECT_LT((momentum() - before).norm(), 4 * std::sqrt(n) * kEpsilon * 1e4);
}

// The wrench (f, t) at P is the wrench (f, t + r × f) at the centre.
TEST(MbsMotion, WrenchAtAnOffsetPortEqualsForceAndTorqueAtTheCentre) {
  Params params = params_with_step(kMillisecond);
  BodyParams body = body_at("body", 2.0, {1.0, 2.0, 3.0}, {0.1, 0.2, 0.25});
  body.q_WB = Eigen::AngleAxisd(1.0, Eigen::Vector3d(3.0, -1.0, 2.0).normalized());
  params.bodies = {body};
  params.ports = {port_on("centre", "body")};
  const Eigen::Vector3d r(0.3, -0.2, 0.5);
  RigidWorld at_centre(params);
  params.ports = {port_at("offset", "body", body.p_WB + r)};
  RigidWorld at_offset(params);
  WrenchSet offset(1), centre(1);
  offset[0].f_P_W = {10.0, 20.0, -5.0};
  offset[0].t_P_W = {0.5, -0.3, 0.2};
  centre[0].f_P_W = offset[0].f_P_W;
  centre[0].t_P_W = offset[0].t_P_W + r.cross(offset[0].f_P_W);
  run(at_centre, kMillisecond, 1, centre);
  run(at_offset, kMillisecond, 1, offset);
  const BodyState& a = at_centre.state().bodies[0];
  const BodyState& b = at_offset.state().bodies[0];
  EXPECT_EQ((a.v_WB - b.v_WB).norm(), 0.0);
  EXPECT_LT((a.w_WB - b.w_WB).norm(), 16 * kEpsilon * a.w_WB.norm());
}

TEST(MbsMotion, PortsReportPoseAndTwistOfTheirFrame) {
  Params params = params_with_step(kMillisecond);
  BodyParams body = body_at("body", 1.0, {1.0, 0.0, 0.0});
  body.v_WB = {0.0, 1.0, 0.0};
  body.w_WB = {0.0, 0.0, 2.0};
  body.q_WB = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY());
  params.bodies = {body};
  const Eigen::Quaterniond q_WP(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
  params.ports = {port_at("port", "body", {1.0, 0.5, 0.25}, q_WP), port_on("frame", "body")};
  RigidWorld world(params);
  const MotionSet motions = world.initialize(WrenchSet(2));
  EXPECT_LT((motions[0].p_WP - Eigen::Vector3d(1.0, 0.5, 0.25)).norm(), 4 * kEpsilon);
  EXPECT_LT(motions[0].q_WP.angularDistance(q_WP), 1e-15);
  // v + w × r = (0, 1, 0) + (0, 0, 2) × (0, 0.5, 0.25)
  EXPECT_LT((motions[0].v_WP - Eigen::Vector3d(-1.0, 1.0, 0.0)).norm(), 8 * kEpsilon);
  EXPECT_EQ(motions[0].w_WP, body.w_WB);
  EXPECT_EQ(motions[1].p_WP, body.p_WB);
  EXPECT_LT((motions[1].q_WP.coeffs() - body.q_WB.coeffs()).norm(), 4 * kEpsilon);
}

// The wrench rises from 0 to F within the macro step H of four micro steps. Semi-implicit Euler
// takes its end as the mean, v⁺ = H F/m; Verlet as linear, v⁺ = H F/(2 m).
TEST(MbsMotion, MicroStepsTakeTheWrenchAsTheirIntegratorDoes) {
  for (const IntegratorKind integrator : {IntegratorKind::Euler, IntegratorKind::Verlet}) {
    Params params = params_with_step(4 * kMillisecond);
    params.integrator = integrator;
    params.micro_step = kMillisecond;
    params.bodies = {body_at("body", 2.0, Eigen::Vector3d::Zero())};
    params.ports = {port_on("port", "body")};
    RigidWorld world(params);
    EXPECT_EQ(world.info().micro_step, kMillisecond);
    WrenchSet begin(1), end(1);
    end[0].f_P_W.x() = 8.0;
    world.advance(step_of(4 * kMillisecond, begin, end));
    const double part = integrator == IntegratorKind::Verlet ? 0.5 : 1.0;
    EXPECT_NEAR(world.state().bodies[0].v_WB.x(), part * 4e-3 * 8.0 / 2.0, 4e-17);
    EXPECT_EQ(world.state().time, 4 * kMillisecond);
  }
}

constexpr JointKind kDrivenKinds[] = {JointKind::Hinge, JointKind::Slider};

/// A load that the motor has to hold: 7 N·m about and 7 N along z.
WrenchSet load_on_motor() {
  WrenchSet load(1);
  load[0].f_P_W.z() = load[0].t_P_W.z() = 7.0;
  return load;
}

// Without cfm the motor is rigid: the joint moves by ∫ law dt, whatever the load, and its rate over
// each step is the law's mean.
TEST(MbsMotion, SpeedMotorsFollowEveryLawToRoundOff) {
  const HarmonicLaw sine{1.0, 2.0, 5.0, 0.3};
  const auto integral_of_sine = [&](double t) {
    const double rate = 2.0 * std::numbers::pi * sine.frequency_Hz;
    return sine.offset * t -
           sine.amplitude / rate * (std::cos(rate * t + sine.phase_rad) - std::cos(sine.phase_rad));
  };
  const std::vector<std::pair<Law, std::function<double(double)>>> laws = {
      {constant(3.0), [](double t) { return 3.0 * t; }},
      {Law(RampLaw{0.01, 0.05, 0.0, 10.0}),
       [](double t) {
         return t < 0.05 ? 125.0 * std::pow(std::max(0.0, t - 0.01), 2) : 0.2 + 10.0 * (t - 0.05);
       }},
      {Law(sine), integral_of_sine}};
  for (const JointKind kind : kDrivenKinds) {
    for (const auto& [law, integral] : laws) {
      RigidWorld world(driven_wheel({.kind = MotorParams::Kind::Speed, .law = law}, kind));
      for (int i = 1; i <= 100; ++i) {
        run(world, kMillisecond, 1, load_on_motor());
        const double t = to_seconds(world.state().time);
        // A few ulps of rates up to 10 and of what the load adds in a step; of the difference of
        // two integrals, divided by the step.
        const BodyState& wheel = world.state().bodies[0];
        EXPECT_NEAR(kind == JointKind::Hinge ? wheel.w_WB.z() : wheel.v_WB.z(),
                    (integral(t) - integral(t - 1e-3)) / 1e-3, 5e-13);
        EXPECT_NEAR(coordinate_of(world), integral(t), 1e-13);
      }
    }
  }
}

// The rate is chosen so that the end of each step lies on the law: exact at every step.
TEST(MbsMotion, PositionMotorsFollowEveryLawToRoundOff) {
  const std::vector<Law> laws = {constant(3.0), Law(RampLaw{0.0, 0.1, 1.0, 9.0}),
                                 Law(HarmonicLaw{1.0, 2.0, 5.0, 0.3}),
                                 Law(TableLaw{{0.0, 0.02, 0.05, 0.08}, {0.0, 1.0, -8.0, 2.0}})};
  for (const JointKind kind : kDrivenKinds) {
    for (const Law& law : laws) {
      RigidWorld world(driven_wheel({.kind = MotorParams::Kind::Position, .law = law}, kind));
      for (int i = 1; i <= 100; ++i) {
        run(world, kMillisecond, 1, load_on_motor());
        // Angles of up to 9 rad go through more than one turn; the law's value at t = 0 is the
        // pose at t = 0.
        const double t = to_seconds(world.state().time);
        EXPECT_NEAR(coordinate_of(world), law(t) - law(0.0), 1e-13) << t;
      }
    }
  }
}

// Drift decays by (1 − erp) per step: the joint's coordinate was disturbed by a yielding motor.
TEST(MbsMotion, PositionMotorsReturnToTheLawByErp) {
  Params params = driven_wheel(
      {.kind = MotorParams::Kind::Position, .law = constant(0.0), .axis = 1, .max_effort = 1000.0});
  params.erp = 0.25;
  RigidWorld world(params);
  WrenchSet push(1);
  push[0].t_P_W.z() = 2000.0;  // 1000 N·m more than the motor holds: turned by h²·1000/0.2 = 5 mrad
  run(world, kMillisecond, 1, push);
  const double pushed = coordinate_of(world);
  EXPECT_NEAR(pushed, 1e-6 * 1000.0 / 0.2, 1e-15);
  run(world, kMillisecond, 10, WrenchSet(1));
  // The 1000 N·m just stop its 5 rad/s in the first step; nine steps remain to decay.
  EXPECT_NEAR(coordinate_of(world), pushed * std::pow(0.75, 9), 1e-15);
}

// Springs, dampers and joints act in pairs along one line: linear and angular momentum stay zero.
TEST(MbsMotion, InternalForcesKeepLinearAndAngularMomentum) {
  Params params = params_with_step(kMillisecond);
  params.erp = 0.0;  // pushing bodies back onto their joint is no motion of mechanics
  params.bodies = {body_at("a", 1.0, Eigen::Vector3d::Zero()), body_at("b", 2.0, {0.3, 0.2, 0.5}),
                   body_at("c", 1.5, {-0.4, 0.6, 0.1})};
  params.joints = {joint_between("guide", JointKind::Slider, "a", "b", Eigen::Vector3d::Zero(), kZ),
                   joint_between("pin", JointKind::Hinge, "c", "a", {-0.2, 0.3, 0.0}, kZ)};
  params.joint_springs = {
      {.name = "axial", .joint = "guide", .stiffness = 50.0, .damping = 0.5, .rest = 0.2},
      {.name = "coil", .joint = "pin", .stiffness = 20.0, .damping = 0.1, .rest = 0.5}};
  params.springs = {{.name = "spring",
                     .body1 = "b",
                     .body2 = "c",
                     .p1_W = {0.1, 0.2, 0.6},
                     .p2_W = {-0.5, 0.5, 0.0},
                     .stiffness_N_per_m = 30.0,
                     .damping_N_s_per_m = 0.4,
                     .rest_length_m = 0.3}};
  RigidWorld world(params);
  run(world, kMillisecond, 1);
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const BodyState& body = world.state().bodies[i];
    const Eigen::Vector3d p =
        params.bodies[i].p_WB;  // the step pushes in the pose at its beginning
    linear += params.bodies[i].mass_kg * body.v_WB;
    angular += params.bodies[i].mass_kg * p.cross(body.v_WB) + body.w_WB;
  }
  // Forces of some 10 N, levers below 1 m, h = 1 ms: impulses of 1e-2 N s. Joints are solved to
  // their condition number, some 10.
  EXPECT_LT(linear.norm(), 100 * kEpsilon * 1e-2);
  EXPECT_LT(angular.norm(), 100 * kEpsilon * 1e-2);
  EXPECT_GT(world.observe().energy.kinetic_J, 1e-6);
}

TEST(MbsMotion, LimitedMotorsSaturate) {
  const double torque = 0.4;
  RigidWorld world(driven_wheel(
      {.kind = MotorParams::Kind::Speed, .law = constant(100.0), .axis = 1, .max_effort = torque}));
  const int n = 100;
  run(world, kMillisecond, n, WrenchSet(1));
  // w = τ t / I, by n roundings
  EXPECT_NEAR(world.state().bodies[0].w_WB.z(), torque * 0.1 / 0.2, n * kEpsilon);
  // The motor's work is its torque times the angle, h² τ/I (1 + 2 + … + n).
  const EnergyBook energy = world.observe().energy;
  const double angle = 1e-6 * torque / 0.2 * 0.5 * n * (n + 1);
  EXPECT_NEAR(energy.external_work_J, torque * angle, n * kEpsilon * torque * angle);
}

TEST(MbsMotion, LimitsStopAHingeAndASlider) {
  for (const JointKind kind : {JointKind::Hinge, JointKind::Slider}) {
    for (const double sign : {1.0, -1.0}) {
      Params params = params_with_step(kMillisecond);
      params.bodies = {body_at("body", 1.0, Eigen::Vector3d::Zero())};
      JointParams joint = joint_between("joint", kind, "body", kWorld, Eigen::Vector3d::Zero(), kZ);
      joint.limits = {{.axis = 1, .lower = -0.1, .upper = 0.1}};
      params.joints = {joint};
      params.ports = {port_on("port", "body")};
      RigidWorld world(params);
      WrenchSet push(1);
      push[0].f_P_W.z() = push[0].t_P_W.z() = sign * 10.0;
      double furthest = 0.0;
      for (int i = 0; i < 1000; ++i) {
        run(world, kMillisecond, 1, push);
        furthest = std::max(furthest, std::abs(coordinate_of(world)));
      }
      // It arrives with √(2·10·0.1) = 1.41 and overshoots by less than one step of that speed;
      // then it rests on the limit, which holds without cfm.
      EXPECT_GT(furthest, 0.1);
      EXPECT_LT(furthest, 0.1 + 1.42e-3);
      EXPECT_NEAR(coordinate_of(world), sign * 0.1, 1e-4);
    }
  }
}

TEST(MbsMotion, AnglesOfUniversalAndHinge2CountBody1AgainstBody2) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  for (const JointKind kind : {JointKind::Universal, JointKind::Hinge2}) {
    for (const int axis : {1, 2}) {
      Params params = params_with_step(kMillisecond);
      params.bodies = {body_at("a", 1.0, Eigen::Vector3d::Zero()),
                       body_at("b", 1.0, Eigen::Vector3d::Zero())};
      JointParams joint = joint_between("joint", kind, "a", "b", Eigen::Vector3d::Zero(), kZ, x);
      joint.motor =
          MotorParams{.kind = MotorParams::Kind::Speed, .law = constant(2.0), .axis = axis};
      params.joints = {joint};
      RigidWorld world(params);
      run(world, kMillisecond, 100);
      // Equal bodies share the relative rate of 2 rad/s.
      const Eigen::Vector3d expected = (axis == 1 ? kZ : x) * 1.0;
      EXPECT_LT((world.state().bodies[0].w_WB - expected).norm(), 1e-12);
      EXPECT_LT((world.state().bodies[1].w_WB + expected).norm(), 1e-12);
      const auto which = static_cast<std::size_t>(axis - 1);
      EXPECT_NEAR(world.state().joint_coordinates[0][which], 0.2, 1e-12);
    }
  }
}

TEST(MbsMotion, UniversalLimitsHoldBothAxes) {
  Params params = params_with_step(kMillisecond);
  params.bodies = {body_at("body", 1.0, Eigen::Vector3d::Zero())};
  JointParams joint = joint_between("joint", JointKind::Universal, "body", kWorld,
                                    Eigen::Vector3d::Zero(), kZ, Eigen::Vector3d::UnitX());
  joint.limits = {{.axis = 1, .lower = -0.1, .upper = 0.2},
                  {.axis = 2, .lower = -0.3, .upper = 0.1}};
  params.joints = {joint};
  params.ports = {port_on("port", "body")};
  RigidWorld world(params);
  WrenchSet push(1);
  push[0].t_P_W = {-5.0, 0.0, 5.0};
  run(world, kMillisecond, 2000, push);
  EXPECT_NEAR(world.state().joint_coordinates[0][0], 0.2, 1e-3);
  EXPECT_NEAR(world.state().joint_coordinates[0][1], -0.3, 1e-3);
}

TEST(MbsMotion, ForceLawsActAlongTheirDirectionAtTheirPoint) {
  Params params = params_with_step(kMillisecond);
  params.bodies = {body_at("body", 2.0, Eigen::Vector3d::Zero(), {0.1, 0.2, 0.25})};
  params.forces = {{.name = "pull",
                    .body = "body",
                    .p_BF = {0.5, 0.0, 0.0},
                    .direction_W = {0.0, 10.0, 0.0},
                    .law = constant(4.0)},
                   {.name = "twist",
                    .body = "body",
                    .kind = ForceParams::Kind::Torque,
                    .direction_W = {1.0, 0.0, 0.0},
                    .law = constant(3.0)}};
  RigidWorld world(params);
  run(world, kMillisecond, 1);
  const BodyState& body = world.state().bodies[0];
  EXPECT_LT((body.v_WB - Eigen::Vector3d(0.0, 4.0e-3 / 2.0, 0.0)).norm(), 1e-17);
  EXPECT_LT((body.w_WB - Eigen::Vector3d(3.0e-3 / 0.1, 0.0, 0.5 * 4.0e-3 / 0.25)).norm(), 1e-16);
}

}  // namespace
}  // namespace tandem::mbs::testing
