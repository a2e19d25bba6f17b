// The tracked vehicle of [JC11] as an example for users: rigid bodies in ODE, track in the flexible
// side, against an independent program with planar rigid bodies. The first 0.6 s of the explicit
// exchange (process/ancf_drive.cpp runs all of it), and converged coupling with longer steps.

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "tests/support/ancf_support.h"
#include "tests/support/beam_pair.h"

namespace tandem::coupled_test {
namespace {

using fem::ancf::testing::number;
using fem::ancf::testing::read_rows;
using fem::ancf::testing::Row;

const std::string kVehicle = "tracked_vehicle/scenario.yaml";

/// What the run shows, one entry per macro step.
struct History {
  std::vector<double> t_s;
  std::vector<Eigen::Vector3d> chassis, momentum, ground;
  std::vector<double> roll;  ///< twice the x component of the chassis' quaternion (rad)
  double lateral_m = 0.0;    ///< farthest of all bodies from the plane y = 0
  double mass_kg = 0.0;
  int halvings = 0;  ///< of the flexible side's steps
  RunReport report;

  [[nodiscard]] std::size_t at(double time_s) const {
    return static_cast<std::size_t>(std::lround(time_s / (t_s[1] - t_s[0])));
  }
  /// Mean force of the ground on the track between two times (N).
  [[nodiscard]] Eigen::Vector3d mean_ground(double from_s, double to_s) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = at(from_s) + 1; i <= at(to_s); ++i) sum -= ground[i];
    return sum / static_cast<double>(at(to_s) - at(from_s));
  }
  [[nodiscard]] Eigen::Vector3d mean_inertia(double from_s, double to_s) const {
    return (momentum[at(to_s)] - momentum[at(from_s)]) / (to_s - from_s);
  }
};

History drive(const std::vector<std::string>& overrides) {
  BeamPair pair(kVehicle, overrides);
  History history;
  history.report = pair.run([&](const BeamPair& now) {
    history.t_s.push_back(now.t_s());
    history.chassis.push_back(now.body("chassis").p_WB);
    history.momentum.push_back(now.momentum());
    history.ground.push_back(now.fem().sums().ground);
    for (const char* body : {"chassis", "sprocket", "idler", "roller1", "roller2"}) {
      history.lateral_m = std::max(history.lateral_m, std::abs(now.body(body).p_WB.y()));
    }
    history.roll.push_back(2.0 * now.body("chassis").q_WB.x());
    history.mass_kg = now.mass_kg();
    history.halvings = now.fem().effort().halvings;
  });
  return history;
}

TEST(AncfVehicle, DrivesAsTheReference) {
  const History run = drive({"run.duration_s=0.6"});
  ASSERT_EQ(run.report.status, RunStatus::Done) << run.report.message;
  EXPECT_NEAR(run.mass_kg, 244.7, 0.05);
  for (const Row& row : read_rows("vehicle_base_full.csv")) {
    const double t = number(row, "t");
    if (t != 0.4 && t != 0.5 && t != 0.6) continue;
    const double moved = run.chassis[run.at(t)].x() - run.chassis[0].x();
    const double expected = number(row, "x") - 0.41866002;
    EXPECT_NEAR(moved, expected, 0.01 * expected) << "t = " << t;
    // Bounce: a few mm/10 about 0.208 m, whose phase is sensitive.
    EXPECT_NEAR(run.chassis[run.at(t)].z(), 0.208, 0.001) << "t = " << t;
  }
  // Symmetric to the plane y = 0: what leaves it is round-off.
  EXPECT_LT(run.lateral_m, 1e-12);
  // Newton's law for the whole: the mean force of the ground is weight and change of momentum.
  const double weight = 9.81 * run.mass_kg;
  const Eigen::Vector3d force = run.mean_ground(0.3, 0.6);
  const Eigen::Vector3d inertia = run.mean_inertia(0.3, 0.6);
  EXPECT_NEAR(force.x(), inertia.x(), 0.02 * inertia.x());
  EXPECT_NEAR(force.z(), inertia.z() + weight, 0.01 * weight);
  EXPECT_GT(inertia.x(), 400.0);
}

// The example has the reference's compatible strains. Its links bend little and its pins a lot:
// strains that do not lock change the drive by no more than the reference's own step does (0.2 %).
TEST(AncfVehicle, DrivesWithAssumedStrainsAsWithCompatibleOnes) {
  const History assumed = drive({"run.duration_s=0.6", "fem.ancf.integration.strain=assumed"});
  const History compatible = drive({"run.duration_s=0.6"});
  ASSERT_EQ(assumed.report.status, RunStatus::Done) << assumed.report.message;
  for (const double t : {0.4, 0.5, 0.6}) {
    const double expected = compatible.chassis[compatible.at(t)].x() - compatible.chassis[0].x();
    const double moved = assumed.chassis[assumed.at(t)].x() - assumed.chassis[0].x();
    EXPECT_NEAR(moved, expected, 0.002 * expected) << "t = " << t;
  }
}

TEST(AncfVehicle, SlidesWithTheFrictionOfTheGround) {
  // μ = 0.2 and a plateau of 30 rad/s: the ground gives μ m g and no more.
  const History run =
      drive({"run.duration_s=0.8", "run.macro_step_s=2e-4", "fem.ancf.contact.friction=0.2",
             "mbs.joints.drive.motor.law.value_end=30"});
  ASSERT_EQ(run.report.status, RunStatus::Done) << run.report.message;
  // The bounce averages out over the long window; μ itself shows without it.
  const Eigen::Vector3d inertia = run.mean_inertia(0.35, 0.8);
  EXPECT_NEAR(inertia.x() / run.mass_kg, 0.2 * 9.81, 0.03 * 0.2 * 9.81);
  EXPECT_NEAR(inertia.x(), 0.2 * run.mean_ground(0.35, 0.8).z(), 0.03 * inertia.x());
}

TEST(AncfVehicle, ConvergedCouplingTakesStepsOfAMillisecond) {
  // The whole drive in steps five times as long as those at which the explicit exchange of friction
  // is unstable. Points touch and let go, stick and slip in nearly every one of them.
  const History run = drive({"run.macro_step_s=1e-3", "coupling.scheme=interface_jacobian"});
  ASSERT_EQ(run.report.status, RunStatus::Done) << run.report.message;
  EXPECT_LT(run.report.iterations_max, 20);
  // No step has to be cut in two: wrenches that do and do not come of halved steps jump, and the
  // interface then has no solution.
  EXPECT_EQ(run.halvings, 0);
  for (const Row& row : read_rows("vehicle_base_full.csv")) {
    const double t = number(row, "t");
    if (t < 0.4 || std::abs(5.0 * t - std::round(5.0 * t)) > 1e-9) continue;
    const double moved = run.chassis[run.at(t)].x() - run.chassis[0].x();
    const double expected = number(row, "x") - 0.41866002;
    // Of first order: this step is ten times that of the reference, whose own error is 0.2 %.
    EXPECT_NEAR(moved, expected, 0.02 * expected) << "t = " << t;
  }
  EXPECT_LT(run.lateral_m, 1e-12);
}

TEST(AncfVehicle, IterationsWithAndWithoutDerivativesAgree) {
  const auto with = [](const std::string& scheme) {
    History run = drive({"run.duration_s=0.3", "run.macro_step_s=5e-4", "coupling.scheme=" + scheme,
                         "coupling.relaxation=iqn_ils"});
    EXPECT_EQ(run.report.status, RunStatus::Done) << run.report.message;
    return run;
  };
  const History newton = with("interface_jacobian");
  const History secants = with("implicit");
  ASSERT_EQ(newton.chassis.size(), secants.chassis.size());
  // Both stop at residuals of 0.02 N; random ones of that size on 245 kg for 0.3 s move it by
  // 4 µm at the very most.
  for (std::size_t i = 0; i < newton.chassis.size(); ++i) {
    ASSERT_LT((newton.chassis[i] - secants.chassis[i]).norm(), 4e-6) << newton.t_s[i];
  }
}

TEST(AncfVehicle, RollsAndTurnsWhenItsChassisIsLopsided) {
  // The chassis' centre of mass 50 mm to the left of the track's middle plane.
  const History run =
      drive({"run.duration_s=0.25", "mbs.bodies.chassis.position_m=[0.41866, 0.05, 0.21]"});
  ASSERT_EQ(run.report.status, RunStatus::Done) << run.report.message;
  // The moment m g a turns it about −x: by more than the ground's k L w³/12 alone lets it, for
  // wheels and band yield as well and the bounce takes it off the ground; by degrees it would fall
  // over.
  const double stiffness = 9e7 * 0.85 * std::pow(0.4, 3) / 12.0;
  const auto from = run.roll.begin() + static_cast<std::ptrdiff_t>(run.at(0.1));
  const double mean =
      std::accumulate(from, run.roll.end(), 0.0) / static_cast<double>(run.roll.end() - from);
  const double expected = -100.0 * 9.81 * 0.05 / stiffness;
  EXPECT_LT(mean, expected);
  EXPECT_GT(mean, 100.0 * expected);
  EXPECT_GT(run.lateral_m - 0.05, 1e-6);
  const Eigen::Vector3d force = run.mean_ground(0.1, 0.25);
  EXPECT_NEAR(force.y(), run.mean_inertia(0.1, 0.25).y(), 1e-3 * force.z());
}

// Chassis, wheels and track lose and gain what is booked, teeth included: what the balance lacks is
// that of contacts which begin or end within a step, and falls with it. Without what pins take out
// of their seats it was 12 J at 0.4 s, whatever the step.
TEST(AncfVehicle, BalanceErrorFallsWithTheStep) {
  const auto largest_error_J = [](const std::string& step_s) {
    BeamPair pair(kVehicle, {"run.duration_s=0.5", "run.macro_step_s=" + step_s});
    const RunReport report = pair.run([](const BeamPair&) {});
    EXPECT_EQ(report.status, RunStatus::Done) << report.message;
    const EnergyBook end = report.energy_end.sum();
    EXPECT_GT(end.external_work_J, 50.0);
    return std::abs(balance_error_J(report.energy_start.sum(), end));
  };
  const double coarse_J = largest_error_J("1e-4");
  EXPECT_LT(coarse_J, 0.1);
  EXPECT_LT(largest_error_J("5e-5"), 0.6 * coarse_J);
}

}  // namespace
}  // namespace tandem::coupled_test
