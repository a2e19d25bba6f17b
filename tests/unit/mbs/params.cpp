// What the multibody side refuses, and how it fails: the element, the key and the remedy are named.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/support/mbs_mechanisms.h"

// A fault that unwinds ODE's step loses the one job (80 bytes) that its loop held on the stack.
// That is ODE's alone to free, so only this allocation is excused from leak checking.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:PreallocateJobInfos"; }

namespace tandem::mbs::testing {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Params sound_params() {
  Params params = params_with_step(kMillisecond);
  params.bodies = {body_at("crank", 1.0, Eigen::Vector3d::Zero()),
                   body_at("rod", 1.0, Eigen::Vector3d::UnitX())};
  params.joints = {
      joint_between("pin", JointKind::Hinge, "crank", kWorld, Eigen::Vector3d::Zero(),
                    Eigen::Vector3d::UnitZ()),
      joint_between("cross", JointKind::Universal, "rod", "crank", Eigen::Vector3d::Zero(),
                    Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY())};
  params.springs = {{.name = "spring",
                     .body1 = "rod",
                     .body2 = kWorld,
                     .p1_W = Eigen::Vector3d::UnitX(),
                     .p2_W = Eigen::Vector3d::Zero(),
                     .stiffness_N_per_m = 1.0}};
  params.joint_springs = {{.name = "coil", .joint = "pin", .stiffness = 1.0}};
  params.forces = {{.name = "push",
                    .body = "rod",
                    .direction_W = Eigen::Vector3d::UnitX(),
                    .law = constant(1.0)}};
  params.ports = {port_on("port", "rod")};
  return params;
}

struct Fault {
  std::function<void(Params&)> spoil;
  std::string said;  ///< must be part of the error
};

TEST(MbsParams, SoundOnesPass) { EXPECT_NO_THROW(check(sound_params())); }

TEST(MbsParams, RangesOfSeveralTurnsAndMotorsThatYieldBetweenThemPass) {
  Params params = sound_params();
  params.joints[0].limits = {{1, -4.0, 20.0}};
  params.joints[0].motor = MotorParams{
      .kind = MotorParams::Kind::Speed, .law = constant(1.0), .axis = 1, .max_effort = 5.0};
  EXPECT_NO_THROW(check(params));
}

TEST(MbsParams, EveryFaultIsNamed) {
  const MotorParams motor{.kind = MotorParams::Kind::Speed, .law = constant(1.0)};
  const std::vector<Fault> faults = {
      {[](Params& p) { p.gravity_m_per_s2.x() = kInfinity; }, "gravity_m_per_s2"},
      {[](Params& p) { p.erp = 1.5; }, "erp"},
      {[](Params& p) { p.cfm = -1.0; }, "cfm"},
      {[](Params& p) { p.micro_step = SimTime(0); }, "micro_step_s"},
      {[](Params& p) { p.bodies[0].name = "world"; }, "'world' is the fixed frame"},
      {[](Params& p) { p.bodies[1].name = "crank"; }, "'crank': name is used twice"},
      {[](Params& p) { p.bodies[0].mass_kg = 0.0; }, "body 'crank': mass_kg"},
      {[](Params& p) { p.bodies[0].inertia_kg_m2 = {1, 1, 1, 2, 0, 0}; }, "positive definite"},
      {[](Params& p) { p.bodies[0].inertia_kg_m2 = {1, 1, 2.5, 0, 0, 0}; }, "triangle inequality"},
      {[](Params& p) { p.bodies[0].p_WB.y() = kInfinity; }, "position_m"},
      {[](Params& p) { p.bodies[0].q_WB.coeffs() *= 2.0; }, "orientation_wxyz"},
      {[](Params& p) { p.bodies[0].v_WB.z() = kInfinity; }, "velocity_m_per_s"},
      {[](Params& p) { p.bodies[0].w_WB.z() = kInfinity; }, "angular_velocity_rad_per_s"},
      {[](Params& p) { p.joints[0].body1 = "cranc"; }, "Did you mean 'crank'?"},
      {[](Params& p) { p.joints[0].body1 = "world"; }, "Name the moving body first"},
      {[](Params& p) { p.joints[1].body2 = "rod"; }, "cannot be connected with itself"},
      {[](Params& p) { p.joints[0].axis_W.setZero(); }, "joint 'pin': axis:"},
      {[](Params& p) { p.joints[0].axis2_W.setOnes(); }, "has no axis2"},
      {[](Params& p) { p.joints[1].axis2_W = -p.joints[1].axis_W; }, "parallel"},
      {[](Params& p) { p.joints[1].axis2_W.z() = 0.5; }, "perpendicular"},
      {[](Params& p) { p.joints[0].kind = JointKind::Ball; }, "has no axis"},
      {[](Params& p) { p.joints[0].p_WA.x() = kInfinity; }, "anchor_m"},
      {[](Params& p) { p.joints[0].kind = JointKind::Hinge2; }, "connects two bodies"},
      {[](Params& p) {
         p.joints[0].limits = {{1, 1.0, -1.0}};
       },
       "reversed"},
      {[](Params& p) {
         p.joints[0].limits = {{1, 0.5, 1.0}};
       },
       "excludes 0"},
      {[](Params& p) {
         p.joints[0].limits = {{2, -1.0, 1.0}};
       },
       "axis 2 does not exist"},
      {[](Params& p) {
         p.joints[0].limits = {{1, -1.0, 1.0}, {1, -1.0, 1.0}};
       },
       "limited twice"},
      {[&](Params& p) {
         p.joints[0].motor = motor;
         p.joints[0].limits = {{1, -1.0, 1.0}};
       },
       "Give it max_torque_Nm"},
      {[&](Params& p) {
         p.joints[0].motor = motor;
         p.joints[0].motor->axis = 2;
       },
       "axis 2 does not exist"},
      {[&](Params& p) {
         p.joints[0].motor = motor;
         p.joints[0].motor->max_effort = 0.0;
       },
       "largest effort"},
      {[&](Params& p) {
         p.joints[0].kind = JointKind::Ball;
         p.joints[0].axis_W.setZero();
         p.joints[0].motor = motor;
       },
       "no axis to act on"},
      {[](Params& p) { p.springs[0].stiffness_N_per_m = -1.0; }, "stiffness_N_per_m"},
      {[](Params& p) { p.springs[0].damping_N_s_per_m = -1.0; }, "damping_N_s_per_m"},
      {[](Params& p) { p.springs[0].rest_length_m = -1.0; }, "rest_length_m"},
      {[](Params& p) {
         p.springs[0].p2_W = p.springs[0].p1_W;
         p.springs[0].rest_length_m = 1.0;
       },
       "coincide"},
      {[](Params& p) { p.joint_springs[0].joint = "pim"; }, "Did you mean 'pin'?"},
      {[](Params& p) { p.joint_springs[0].damping = -1.0; }, "joint spring 'coil': damping"},
      {[](Params& p) { p.forces[0].direction_W.setZero(); }, "force 'push': direction"},
      {[](Params& p) { p.forces[0].body = "world"; }, "no body 'world'"},
      {[](Params& p) { p.ports[0].body = "ro"; }, "port 'port': body: there is no body 'ro'."},
      {[](Params& p) {
         p.ports[0].at_body_frame = false;
         p.ports[0].p_WP.x() = kInfinity;
       },
       "position_m"},
      {[](Params& p) { p.bodies[0].massless = true; }, "junction 'crank': name: no port is on it"},
      {[](Params& p) {
         p.bodies[1].massless = true;
         p.ports[0].at_body_frame = false;
       },
       "junction 'rod': position_m: none of its ports (port) stands there"},
      {[](Params& p) {
         p.bodies[1].massless = true;
         p.integrator = IntegratorKind::GeneralisedAlpha;
         p.micro_step = kMillisecond / 2;
       },
       "shorten run.macro_step_s"}};
  for (const Fault& fault : faults) {
    Params params = sound_params();
    fault.spoil(params);
    try {
      RigidWorld world(params);
      ADD_FAILURE() << "not refused: " << fault.said;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Usage);
      EXPECT_NE(std::string(error.what()).find(fault.said), std::string::npos)
          << error.what() << " lacks: " << fault.said;
    }
  }
}

TEST(MbsFailure, AWrenchThatIsNotFiniteFailsAndLeavesTheStateAlone) {
  RigidWorld world(sound_params());
  run(world, kMillisecond, 5, WrenchSet(1));
  const auto before = world.observe().state_hash;
  // The second is a number, but its square is none: ODE would end in an assertion.
  for (const double force_N : {std::numeric_limits<double>::quiet_NaN(), 1e200}) {
    WrenchSet bad(1);
    bad[0].f_P_W.x() = force_N;
    const auto result = world.advance(step_of(kMillisecond, WrenchSet(1), bad));
    EXPECT_EQ(result.outcome, Outcome::Failed);
    EXPECT_NE(result.message.find("wrench is not finite"), std::string::npos) << result.message;
    EXPECT_EQ(world.observe().state_hash, before);
  }
}

// The time of a failure is told in full, of however short a step.
TEST(MbsFailure, NamesItsTimeToTheNanosecond) {
  Params params = sound_params();
  params.macro_step = SimTime(123);
  RigidWorld world(params);
  run(world, SimTime(123), 3, WrenchSet(1));
  WrenchSet bad(1);
  bad[0].f_P_W.x() = std::numeric_limits<double>::quiet_NaN();
  const auto result = world.advance(step_of(SimTime(123), WrenchSet(1), bad));
  EXPECT_NE(result.message.find("t = 3.69e-07 s."), std::string::npos) << result.message;
}

// Overflow inside ODE ends in a failed assertion or in infinities, depending on where it happens;
// either way the step fails, the state stays, and the run can go on.
TEST(MbsFailure, OverflowFailsWithoutEndingTheProcessAndCanBeRolledBack) {
  RigidWorld calm(sound_params());
  RigidWorld world(sound_params());
  const WrenchSet none(1);
  run(calm, kMillisecond, 10, none);
  run(world, kMillisecond, 5, none);
  const auto before = world.observe().state_hash;
  for (const double size : {1e150, 1e300, 1.7e308}) {
    for (const bool torque : {false, true}) {
      WrenchSet huge(1);
      (torque ? huge[0].t_P_W : huge[0].f_P_W).setConstant(size);
      // Several steps: the first may still end with finite, absurd rates.
      world.checkpoint();
      Outcome outcome = Outcome::Done;
      std::string message;
      for (int i = 0; i < 3 && outcome == Outcome::Done; ++i) {
        const auto result = world.advance(step_of(kMillisecond, huge, huge));
        outcome = result.outcome;
        message = result.message;
      }
      EXPECT_EQ(outcome, Outcome::Failed) << size;
      EXPECT_NE(message.find("mbs: "), std::string::npos) << message;
      world.rollback();
      EXPECT_EQ(world.observe().state_hash, before);
    }
  }
  run(world, kMillisecond, 5, none);
  EXPECT_EQ(world.observe().state_hash, calm.observe().state_hash);
}

TEST(MbsFailure, AMacroStepThatIsNoMultipleOfTheMicroStepIsRefused) {
  Params params = sound_params();
  params.micro_step = SimTime(300'000);
  RigidWorld world(params);
  EXPECT_THROW(world.advance(step_of(kMillisecond, WrenchSet(1), WrenchSet(1))), Error);
  EXPECT_THROW(world.advance(step_of(kMillisecond, WrenchSet(2), WrenchSet(2))), Error);
}

}  // namespace
}  // namespace tandem::mbs::testing
