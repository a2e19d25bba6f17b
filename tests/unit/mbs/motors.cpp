// Motors that yield, alone, against a load and against the stops of their own coordinate.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/mbs_coordinate.h"

namespace tandem::mbs::testing {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

MotorParams motor_on(const Coordinate& tested, double rate, double max_effort) {
  return {.kind = MotorParams::Kind::Speed,
          .law = constant(rate),
          .axis = tested.axis,
          .max_effort = max_effort};
}

/// Displacement from rest under a constant acceleration a after n steps: the sum of semi-implicit
/// Euler, a h² n (n + 1)/2, or Verlet's, which is exact.
double fall(IntegratorKind integrator, double a, double h_s, int n) {
  const double steps = integrator == IntegratorKind::Euler ? n * (n + 1.0) : n * 1.0 * n;
  return 0.5 * a * h_s * h_s * steps;
}

// A brake of 8 holds 7 and yields to 10, which then moves the inertia of 1 by the difference.
TEST(MbsMotors, BrakesYieldAtTheirLargestEffort) {
  for (const Coordinate& tested : kCoordinates) {
    for (const IntegratorKind integrator : kIntegrators) {
      SCOPED_TRACE(text_of(tested, integrator));
      Params params = body_on(tested, integrator, kMillisecond);
      params.joints[0].motor = motor_on(tested, 0.0, 8.0);
      RigidWorld world(params);
      run(world, kMillisecond, 100, effort_on(tested, 7.0));
      EXPECT_NEAR(coordinate_of(world, tested), 0.0, 100 * kEpsilon);
      run(world, kMillisecond, 1000, effort_on(tested, -10.0));
      // 1000 roundings of numbers up to 2, in the coordinate by way of a quaternion.
      EXPECT_NEAR(coordinate_of(world, tested), fall(integrator, -2.0, 1e-3, 1000), 1e-12);
      EXPECT_NEAR(rate_of(world, tested), -2.0, 1e-12);
    }
  }
}

// A motor of 2 that is to turn (slide) at 10 accelerates the inertia of 1 by 2.
TEST(MbsMotors, DrivesAccelerateByTheirLargestEffort) {
  for (const Coordinate& tested : kCoordinates) {
    for (const IntegratorKind integrator : kIntegrators) {
      SCOPED_TRACE(text_of(tested, integrator));
      Params params = body_on(tested, integrator, kMillisecond);
      params.joints[0].motor = motor_on(tested, 10.0, 2.0);
      RigidWorld world(params);
      run(world, kMillisecond, 500, WrenchSet(1));
      EXPECT_NEAR(coordinate_of(world, tested), fall(integrator, 2.0, 1e-3, 500), 1e-13);
      // Its work is its effort times the way.
      EXPECT_NEAR(world.observe().energy.external_work_J, 2.0 * coordinate_of(world, tested),
                  1e-12);
    }
  }
}

// A motor's row is rate + cfm μ = law: under the load F it falls behind by cfm F.
TEST(MbsMotors, SlipByCfmTimesTheirEffort) {
  for (const Coordinate& tested : kCoordinates) {
    for (const IntegratorKind integrator : kIntegrators) {
      SCOPED_TRACE(text_of(tested, integrator));
      Params params = body_on(tested, integrator, kMillisecond);
      params.cfm = 1e-4;
      params.joints[0].motor = motor_on(tested, 1.0, std::numeric_limits<double>::infinity());
      RigidWorld world(params);
      const WrenchSet load = effort_on(tested, -500.0);
      run(world, kMillisecond, 100, load);
      const double begin = coordinate_of(world, tested);
      run(world, kMillisecond, 100, load);
      EXPECT_NEAR(rate_of(world, tested), 1.0 - 0.05, 1e-12);
      EXPECT_NEAR(coordinate_of(world, tested) - begin, 0.1 * (1.0 - 0.05), 1e-12);
    }
  }
}

constexpr double kSag = 1e-11;

/// A motor of 8 that is to move at ± 1 between stops at −0.1 and 0.1. With the default cfm the
/// stops yield by cfm F h/erp, 1e-11 for 20 of effort, without which a body at rest on one would
/// leave it by round-off, fall back for a step and overshoot anew.
Params driven_between_stops(const Coordinate& tested, IntegratorKind integrator, double sign) {
  Params params = body_on(tested, integrator, kMillisecond);
  params.cfm = Params{}.cfm;
  params.joints[0].limits = {{.axis = tested.axis, .lower = -0.1, .upper = 0.1}};
  params.joints[0].motor = motor_on(tested, sign, 8.0);
  return params;
}

bool may_be_limited(const Coordinate& tested) {
  return tested.kind != JointKind::Hinge2 || tested.axis == 1;
}

// The motor takes the body to the stop at its rate and presses it there with 8: 7 the other way do
// not lift it, 9 pull it off with the difference.
TEST(MbsMotors, PressAgainstTheStopsOfTheirCoordinate) {
  for (const Coordinate& tested : kCoordinates) {
    if (!may_be_limited(tested)) continue;
    for (const IntegratorKind integrator : kIntegrators) {
      for (const double sign : {1.0, -1.0}) {
        SCOPED_TRACE(text_of(tested, integrator));
        RigidWorld world(driven_between_stops(tested, integrator, sign));
        // From rest it takes 1/8 s to the rate 1, on a way of 1/16.
        run(world, kMillisecond, 150, WrenchSet(1));
        EXPECT_NEAR(rate_of(world, tested), sign, 1e-9);  // it slips by cfm F
        double furthest = 0.0;
        for (int i = 0; i < 200; ++i) {
          run(world, kMillisecond, 1, WrenchSet(1));
          furthest = std::max(furthest, sign * coordinate_of(world, tested));
        }
        EXPECT_LT(furthest, 0.1 + 1e-3);  // a step of the rate
        // 0.8 of the overshoot is left after each step.
        EXPECT_NEAR(coordinate_of(world, tested), sign * 0.1, kSag);
        run(world, kMillisecond, 100, effort_on(tested, -sign * 7.0));
        EXPECT_NEAR(coordinate_of(world, tested), sign * 0.1, kSag);
        EXPECT_NEAR(rate_of(world, tested), 0.0, 1e-9);
        const double at_stop = coordinate_of(world, tested);
        run(world, kMillisecond, 100, effort_on(tested, -sign * 9.0));
        EXPECT_NEAR(coordinate_of(world, tested),
                    at_stop + fall(integrator, -sign * 1.0, 1e-3, 100), 20 * kSag);
      }
    }
  }
}

// A load of 12 holds the body on its stop against the motor of 8; a load of 5 lets it leave with
// the acceleration of the difference, until it has its rate.
TEST(MbsMotors, LeaveAStopWithTheEffortThatTheLoadLeavesThem) {
  for (const Coordinate& tested : kCoordinates) {
    if (!may_be_limited(tested)) continue;
    for (const IntegratorKind integrator : kIntegrators) {
      SCOPED_TRACE(text_of(tested, integrator));
      RigidWorld world(driven_between_stops(tested, integrator, 1.0));
      run(world, kMillisecond, 1000, effort_on(tested, -12.0));
      EXPECT_NEAR(coordinate_of(world, tested), -0.1, kSag);
      const double at_stop = coordinate_of(world, tested);
      run(world, kMillisecond, 200, effort_on(tested, -5.0));
      EXPECT_NEAR(coordinate_of(world, tested), at_stop + fall(integrator, 3.0, 1e-3, 200),
                  20 * kSag);
    }
  }
}

// Motor and stop are two equal rows of the step. They are told apart without cfm, too, where a body
// at rest on a stop may overshoot by a step's fall, h² F.
TEST(MbsMotors, PressAgainstStopsThatAreExact) {
  for (const Coordinate& tested : kCoordinates) {
    if (!may_be_limited(tested)) continue;
    for (const IntegratorKind integrator : kIntegrators) {
      for (const double inertia : {1.0, 1e-6}) {
        SCOPED_TRACE(text_of(tested, integrator));
        Params params = driven_between_stops(tested, integrator, 1.0);
        params.cfm = 0.0;
        params.bodies[0].mass_kg = inertia;
        params.bodies[0].inertia_kg_m2 = {inertia, inertia, inertia, 0.0, 0.0, 0.0};
        params.joints[0].motor->max_effort = 8.0 * inertia;
        RigidWorld world(params);
        for (const double load : {0.0, -7.0, 20.0, -6.0}) {
          run(world, kMillisecond, 300, effort_on(tested, load * inertia));
          EXPECT_NEAR(coordinate_of(world, tested), 0.1, load == 0.0 ? 1e-3 : 28e-6);
        }
      }
    }
  }
}

// A stop takes the energy of what meets it: a loss, and no work of the brake on the joint's other
// axis.
TEST(MbsMotors, ABrakeDoesNotWorkWhereTheStopOfTheOtherAxisActs) {
  for (const IntegratorKind integrator : kIntegrators) {
    Params params = body_on({JointKind::Universal, 1}, integrator, kMillisecond);
    params.bodies[0].w_WB = {1.9, 0.0, 0.0};
    params.joints[0].limits = {{.axis = 2, .lower = -0.1, .upper = 0.1}};
    params.joints[0].motor = motor_on({JointKind::Universal, 1}, 0.0, 100.0);
    RigidWorld world(params);
    run(world, kMillisecond, 500, WrenchSet(1));
    const EnergyBook energy = world.observe().energy;
    EXPECT_NEAR(energy.external_work_J, 0.0, 1e-12);
    // It overshoots by 0.7 mrad in the 53rd step, of which the stop pushes 0.2 back in the next.
    EXPECT_NEAR(energy.kinetic_J, 0.5 * 0.14 * 0.14, 1e-12);
    EXPECT_NEAR(energy.numerical_loss_J, 0.5 * 1.9 * 1.9 - energy.kinetic_J, 1e-12);
  }
}

// Off its centre, and between two free bodies: a slider's motor acts in pairs along one line.
TEST(MbsMotors, OfASliderKeepTheMomentaOfItsBodies) {
  Params params = params_with_step(kMillisecond);
  params.erp = 0.0;  // pushing bodies back onto their joint is no motion of mechanics
  params.bodies = {body_at("a", 1.0, {0.3, 0.0, 0.1}), body_at("b", 2.0, {0.0, 0.4, -0.2})};
  JointParams guide = joint_between("guide", JointKind::Slider, "a", "b", Eigen::Vector3d::Zero(),
                                    Eigen::Vector3d(1.0, 2.0, 2.0));
  guide.motor = motor_on({JointKind::Slider, 1}, 10.0, 6.0);
  params.joints = {guide};
  RigidWorld world(params);
  run(world, kMillisecond, 1);
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 2; ++i) {
    const BodyState& body = world.state().bodies[i];
    linear += params.bodies[i].mass_kg * body.v_WB;
    angular += params.bodies[i].mass_kg * params.bodies[i].p_WB.cross(body.v_WB) + body.w_WB;
  }
  // Impulses of 6e-3 N s; joints are solved to their condition number, some 10.
  EXPECT_LT(linear.norm(), 100 * kEpsilon * 6e-3);
  EXPECT_LT(angular.norm(), 100 * kEpsilon * 6e-3);
  EXPECT_GT(world.state().bodies[0].v_WB.norm(), 1e-3);
}

}  // namespace
}  // namespace tandem::mbs::testing
