#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mbs_process/spring_stability.h"
#include "tests/support/mbs_mechanisms.h"

// Explicit springs: how stiff is too stiff, and what is said of those that are.
namespace tandem::mbs {
namespace {

using namespace testing;

/// A body of 2 kg at the origin on a spring along x to the world.
Params on_a_spring(double stiffness_N_per_m, double damping_N_s_per_m) {
  Params params;
  params.gravity_m_per_s2.setZero();
  params.macro_step = kMillisecond;
  params.bodies = {body_at("block", 2.0, {0, 0, 0})};
  params.bodies[0].v_WB = {1e-3, 0, 0};
  params.ports = {port_on("p", "block")};
  params.springs = {{.name = "s",
                     .body1 = "block",
                     .p1_W = {0, 0, 0},
                     .p2_W = {1, 0, 0},
                     .stiffness_N_per_m = stiffness_N_per_m,
                     .damping_N_s_per_m = damping_N_s_per_m}};
  return params;
}

/// Largest speed of the block in the last of n steps; of no number when it fails.
double speed_after(const Params& params, int n) {
  RigidWorld world(params);
  world.initialize(WrenchSet(1));
  double speed = 0.0;
  for (int k = 0; k < n; ++k) {
    const auto result =
        world.advance({.step = kMillisecond, .input = {WrenchSet(1), WrenchSet(1)}});
    if (result.outcome != Outcome::Done) return std::numeric_limits<double>::quiet_NaN();
    speed = std::max(speed, result.output[0].v_WP.norm());
  }
  return speed;
}

// Semi-implicit Euler, v⁺ = v − h (k x + c v)/m, x⁺ = x + h v⁺: trace 2 − h c/m − h² k/m,
// determinant 1 − h c/m; a root passes −1 where h² k/m + 2 h c/m = 4. With m = 2 kg and h = 1 ms
// that is k = 8e6 N/m, or c = 4000 N s/m. Just beyond, the velocity grows; just below, it does not.
TEST(SpringStability, OneSpringIsStableUpToFour) {
  for (const double share : {0.0, 0.3, 1.0}) {
    const Params below = on_a_spring(0.99 * share * 8e6, 0.99 * (1.0 - share) * 4000.0);
    const Params beyond = on_a_spring(1.01 * share * 8e6, 1.01 * (1.0 - share) * 4000.0);
    // The response is exact but for the rounding of 1e-6 m/s in a step.
    EXPECT_NEAR(spring_stability(below).number, 3.96, 1e-8);
    EXPECT_NEAR(spring_stability(beyond).number, 4.04, 1e-8);
    EXPECT_LT(speed_after(below, 200), 0.02);
    EXPECT_GT(speed_after(beyond, 200), 0.02);
    EXPECT_FALSE(spring_warning(below).has_value());
    EXPECT_TRUE(spring_warning(beyond).has_value());
  }
}

// Two bodies in line: the reduced mass. Two equal springs side by side: twice the stiffness. On a
// lever of r from the centre of a body that a ball holds there: I/r².
TEST(SpringStability, TheMassIsTheOneThatTheSpringMoves) {
  Params pair = on_a_spring(1e6, 0.0);
  pair.bodies.push_back(body_at("other", 3.0, {1, 0, 0}));
  pair.springs[0].body2 = "other";
  EXPECT_NEAR(spring_stability(pair).number, 1.0 / 2.0 + 1.0 / 3.0, 1e-8);

  Params twice = on_a_spring(1e6, 0.0);
  twice.springs.push_back(twice.springs[0]);
  twice.springs[1].name = "t";
  EXPECT_NEAR(spring_stability(twice).number, 2.0 / 2.0, 1e-8);

  Params lever = on_a_spring(1e6, 0.0);
  lever.bodies[0] = body_at("block", 2.0, {0, 0, 0}, {0.5, 0.5, 0.5});
  lever.joints = {joint_between("ball", JointKind::Ball, "block", kWorld, {0, 0, 0})};
  lever.springs[0].p1_W = {0, 0.25, 0};
  lever.springs[0].p2_W = {1, 0.25, 0};
  // The constraint force mixing of 1e-10 lets the held centre give way by as much.
  EXPECT_NEAR(spring_stability(lever).number, 0.25 * 0.25 / 0.5, 1e-6);
}

// A torsion spring in a hinge through the centre: h² k/I; the axis has I = 0.5 kg m².
TEST(SpringStability, JointSpringsCount) {
  Params hinged = on_a_spring(0.0, 0.0);
  hinged.springs.clear();
  hinged.bodies[0] = body_at("block", 2.0, {0, 0, 0}, {1, 1, 0.5});
  hinged.joints = {joint_between("hinge", JointKind::Hinge, "block", kWorld, {0, 0, 0}, {0, 0, 1})};
  hinged.joint_springs = {{.name = "torsion", .joint = "hinge", .stiffness = 3e6}};
  const SpringStability found = spring_stability(hinged);
  EXPECT_NEAR(found.number, 6.0, 1e-5);
  EXPECT_EQ(found.spring, "torsion");
  EXPECT_NEAR(found.stable_step_s, 1e-3 * std::sqrt(4.0 / 6.0), 1e-8);
}

// Not ODE's assertion on its normalised quaternions.
TEST(SpringStability, ASpringThatBlowsUpIsNamedWithTheBodyAndTheRemedy) {
  for (const IntegratorKind kind : {IntegratorKind::Euler, IntegratorKind::Verlet}) {
    Params params = on_a_spring(4e7, 0.0);
    params.integrator = kind;
    RigidWorld world(params);
    world.initialize(WrenchSet(1));
    StepResult<MotionSet> result{.outcome = Outcome::Done};
    for (int k = 0; k < 1000 && result.outcome == Outcome::Done; ++k) {
      result = world.advance({.step = kMillisecond, .input = {WrenchSet(1), WrenchSet(1)}});
    }
    EXPECT_EQ(result.outcome, Outcome::Failed);
    for (const char* words : {"body 'block' has grown beyond all bounds at t = ", "spring 's'",
                              "Set mbs.micro_step_s below 0.000447"}) {
      EXPECT_NE(result.message.find(words), std::string::npos) << result.message;
    }
    EXPECT_EQ(result.message.find("assertion"), std::string::npos) << result.message;
  }
}

}  // namespace
}  // namespace tandem::mbs
