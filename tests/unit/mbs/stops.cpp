// Stops act on the coordinate as it is counted through full turns.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/support/mbs_coordinate.h"

namespace tandem::mbs::testing {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Angles that may have stops: those of hinge2's wheel axis turn freely.
constexpr Coordinate kAngles[] = {{JointKind::Hinge, 1},
                                  {JointKind::Universal, 1},
                                  {JointKind::Universal, 2},
                                  {JointKind::Hinge2, 1}};

/// A body with a stop at `stop`, on the side that it lies. With the default cfm the stop yields by
/// cfm T h/erp; without it a body at rest would leave it by round-off, and fall back for a step.
Params body_with_stop(const Coordinate& tested, IntegratorKind integrator, double stop,
                      SimTime h = kMillisecond) {
  Params params = body_on(tested, integrator, h);
  params.cfm = Params{}.cfm;
  LimitParams limit{.axis = tested.axis, .lower = -kInfinity, .upper = kInfinity};
  (stop > 0.0 ? limit.upper : limit.lower) = stop;
  params.joints[0].limits = {limit};
  return params;
}

// An effort T on the inertia 1 arrives at the stop s with √(2 T s), overshoots by no more than a
// step of that (and of what T adds in it), and is back to round-off when 0.8 of the overshoot has
// been left after each of 300 steps. Near π an angle read within one turn would be on the far side.
TEST(MbsStops, HoldAtAnyAngleAndNumberOfTurns) {
  const double h_s = 1e-2, effort = 2.0;
  for (const double stop : {0.1, 3.13, 3.141592653589793, 3.2, 2 * kPi, 9.0, 20.0}) {
    for (const Coordinate& tested : kAngles) {
      for (const IntegratorKind integrator : kIntegrators) {
        for (const double sign : {1.0, -1.0}) {
          SCOPED_TRACE(text_of(tested, integrator) + " at " + std::to_string(sign * stop));
          const Params params = body_with_stop(tested, integrator, sign * stop, 10 * kMillisecond);
          RigidWorld world(params);
          const double arrival_s = std::sqrt(2.0 * stop / effort);
          const double rate = effort * arrival_s;
          const int n = static_cast<int>(arrival_s / h_s) + 300;
          double furthest = 0.0;
          for (int i = 0; i < n; ++i) {
            run(world, 10 * kMillisecond, 1, effort_on(tested, sign * effort));
            furthest = std::max(furthest, sign * coordinate_of(world, tested));
          }
          EXPECT_LE(furthest, stop + h_s * (rate + effort * h_s));
          const double sag = params.cfm * effort * h_s / params.erp;
          EXPECT_NEAR(coordinate_of(world, tested), sign * (stop + sag), 1e-13);
          EXPECT_NEAR(rate_of(world, tested), 0.0, 1e-9);  // Verlet: cfm T
        }
      }
    }
  }
}

// The far end of a range of several turns does nothing before it is reached, although ODE's angle
// passes it in every turn.
TEST(MbsStops, LetTheBodyTurnFreelyWithinTheirRange) {
  for (const Coordinate& tested : kAngles) {
    for (const IntegratorKind integrator : kIntegrators) {
      SCOPED_TRACE(text_of(tested, integrator));
      Params params = body_on(tested, integrator, kMillisecond);
      params.joints[0].limits = {{.axis = tested.axis, .lower = -0.5, .upper = 14.0}};
      const Eigen::Vector3d axis =
          tested.axis == 1 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
      params.bodies[0].w_WB = 10.0 * axis;
      RigidWorld world(params);
      run(world, kMillisecond, 1390, WrenchSet(1));
      EXPECT_NEAR(coordinate_of(world, tested), 13.9, 1e-11);
      EXPECT_NEAR(rate_of(world, tested), 10.0, 1e-11);
      // It overshoots by up to a step of its rate, of which the stop pushes 0.2 back in one.
      double furthest = 0.0;
      for (int i = 0; i < 20; ++i) {
        run(world, kMillisecond, 1, WrenchSet(1));
        furthest = std::max(furthest, coordinate_of(world, tested));
      }
      EXPECT_LT(furthest, 14.0 + 10.0e-3);
      EXPECT_LE(rate_of(world, tested), 1e-9);
      EXPECT_GE(rate_of(world, tested), -0.2 * 10.0);
    }
  }
}

// A body that has rested on a stop leaves it as a free one: θ = s − ½ T t².
TEST(MbsStops, ReleaseTheBodyWhenTheLoadTurns) {
  for (const Coordinate& tested : kAngles) {
    RigidWorld world(body_with_stop(tested, IntegratorKind::Verlet, kPi));
    run(world, kMillisecond, 3000, effort_on(tested, 2.0));
    ASSERT_NEAR(coordinate_of(world, tested), kPi, 1e-11);
    run(world, kMillisecond, 500, effort_on(tested, -2.0));
    EXPECT_NEAR(coordinate_of(world, tested), kPi - 0.25, 1e-9);  // cfm T of rate at the start
  }
}

// lower = upper = 0 locks the coordinate.
TEST(MbsStops, LockACoordinateThatHasNoRange) {
  for (const Coordinate& tested : kAngles) {
    for (const IntegratorKind integrator : kIntegrators) {
      Params params = body_on(tested, integrator, kMillisecond);
      params.joints[0].limits = {{.axis = tested.axis, .lower = 0.0, .upper = 0.0}};
      RigidWorld world(params);
      run(world, kMillisecond, 100, effort_on(tested, 5.0));
      run(world, kMillisecond, 100, effort_on(tested, -5.0));
      EXPECT_NEAR(coordinate_of(world, tested), 0.0, 1e-12);
    }
  }
}

// A step may turn a body by more than half a turn: 5 rad here, counted to round-off, and stopped.
TEST(MbsStops, FollowARotorThatTurnsByMoreThanHalfATurnInAStep) {
  for (const Coordinate& tested : kCoordinates) {
    for (const double rate : {5000.0, -5000.0}) {
      SCOPED_TRACE(text_of(tested, IntegratorKind::Euler));
      Params params = body_on(tested, IntegratorKind::Euler, kMillisecond);
      const Eigen::Vector3d axis =
          tested.axis == 1 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
      (tested.kind == JointKind::Slider ? params.bodies[0].v_WB : params.bodies[0].w_WB) =
          rate * axis;
      RigidWorld world(params);
      run(world, kMillisecond, 100, WrenchSet(1));
      EXPECT_NEAR(coordinate_of(world, tested), 0.1 * rate, 1e-9);
    }
  }
  Params params = body_with_stop({JointKind::Hinge, 1}, IntegratorKind::Euler, 402.0);
  params.bodies[0].w_WB.z() = 5000.0;
  RigidWorld world(params);
  run(world, kMillisecond, 81, WrenchSet(1));
  EXPECT_NEAR(coordinate_of(world, kAngles[0]), 405.0, 1e-9);
  run(world, kMillisecond, 1, WrenchSet(1));  // 0.2 of the overshoot of 3 rad
  EXPECT_NEAR(coordinate_of(world, kAngles[0]), 405.0 - 0.6, 1e-6);  // cfm of 5.6e6 N·m, h
}

/// Hashes of n steps into a stop at 3.14 and beyond a turn, with a linearised trial under another
/// load before each step when `trials` is set.
std::vector<std::uint64_t> hashes_of_run(const Coordinate& tested, IntegratorKind integrator,
                                         double stop, bool trials) {
  RigidWorld world(body_with_stop(tested, integrator, stop));
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 1000; ++i) {
    const WrenchSet wrenches = effort_on(tested, 50.0 - 0.05 * i);
    world.checkpoint();
    if (trials) {
      StepRequest<WrenchSet> trial = step_of(kMillisecond, wrenches, effort_on(tested, -4000.0));
      trial.linearize = true;
      EXPECT_EQ(world.advance(trial).outcome, Outcome::Done);
      world.rollback();
    }
    run(world, kMillisecond, 1, wrenches);
    hashes.push_back(world.observe().state_hash);
  }
  return hashes;
}

TEST(MbsStops, AreRolledBackBitForBit) {
  for (const Coordinate& tested : kAngles) {
    for (const IntegratorKind integrator : kIntegrators) {
      for (const double stop : {3.14, 3.141592653589793, 9.0}) {
        EXPECT_EQ(hashes_of_run(tested, integrator, stop, false),
                  hashes_of_run(tested, integrator, stop, true))
            << text_of(tested, integrator);
      }
    }
  }
}

// Pressed against its stop the coordinate does not answer to a small effort; a step before, it is
// that of a free body: δθ = h² δT, δw = h δT (Verlet: ¼ h² and ½ h of the wrench at the end).
TEST(MbsStops, JacobianIsThatOfAHeldOrFreeCoordinate) {
  const double h = 1e-3;
  for (const IntegratorKind integrator : kIntegrators) {
    const Coordinate tested{JointKind::Hinge, 1};
    RigidWorld world(body_with_stop(tested, integrator, 8.0));
    StepRequest<WrenchSet> request =
        step_of(kMillisecond, effort_on(tested, 50.0), effort_on(tested, 50.0));
    request.linearize = true;
    const bool euler = integrator == IntegratorKind::Euler;
    const InterfaceJacobian free = world.advance(request).jacobian.value();
    EXPECT_NEAR(free(5, 5), (euler ? 1.0 : 0.25) * h * h, 1e-6 * h * h);
    EXPECT_NEAR(free(11, 5), (euler ? 1.0 : 0.5) * h, 1e-6 * h);
    run(world, kMillisecond, 2000, effort_on(tested, 50.0));
    ASSERT_NEAR(coordinate_of(world, tested), 8.0, 1e-10);
    const InterfaceJacobian held = world.advance(request).jacobian.value();
    EXPECT_LT(held.col(5).norm(), 1.001 * world.params().cfm);  // 1e-7 of the free one's
  }
}

}  // namespace
}  // namespace tandem::mbs::testing
