#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/coupled_pair.h"
#include "tests/support/long_tests.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

constexpr const char* kScenario = "slider_crank/scenario.yaml";
constexpr double kRadius = 0.1;   // m, crank pin from the shaft
constexpr double kLength = 0.36;  // m, between the pins

const mbs::BodyState& body(const CoupledPair& pair, const std::string& name) {
  return pair.mbs().state().bodies[mbs::body_index(pair.mbs().params(), name).value()];
}

/// Largest distance (m) of the slider from x = r cos θ + sqrt(l² − r² sin² θ), θ the crank's angle,
/// over the run with a rod of 1e10 Pa.
double largest_kinematic_error_m(double h_s) {
  CoupledPair pair(kScenario,
                   {{"run.macro_step_s", text_of(h_s)}, {"fem.material.young_Pa", "1e10"}});
  double largest = 0.0, travel_low = 1.0, travel_high = 0.0;
  const RunReport report = pair.run(Mode::Monolithic, [&](const Sample&) {
    const double theta = pair.mbs().state().joint_coordinates[0][0];
    const double sine = kRadius * std::sin(theta);
    const double expected = kRadius * std::cos(theta) + std::sqrt(kLength * kLength - sine * sine);
    const double x = body(pair, "slider").p_WB.x();
    largest = std::max(largest, std::abs(x - expected));
    travel_low = std::min(travel_low, x);
    travel_high = std::max(travel_high, x);
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  // The whole stroke was made: from l − r to l + r.
  EXPECT_NEAR(travel_low, kLength - kRadius, 1e-3);
  EXPECT_NEAR(travel_high, kLength + kRadius, 1e-3);
  return largest;
}

// ODE moves a pin along the chord instead of the arc and opens it by r (ω H)²/2 per step, of which
// the joint takes back the part erp = 0.2: at rest with r (ω H)²/(2 erp) = 2.2e-5 m at H = 5e-4 s,
// second order in H. The rod adds 1.5e-6 m: E A / l = 3e7 N/m under 45 N (1.2 kg, r ω² (1 + r/l)).
TEST(SliderCrank, StiffRodFollowsTheRigidKinematics) {
  const double omega = 18.85;
  const double H = 5e-4;
  const double error_m = largest_kinematic_error_m(H);
  EXPECT_LT(error_m, 1.25 * (kRadius * std::pow(omega * H, 2) / (2 * 0.2) + 1.5e-6));
  EXPECT_NEAR(std::log2(largest_kinematic_error_m(2.0 * H) / error_m), 2.0, 0.15);
}

/// Ends of the rod turned against each other (rad), largest over the run.
double largest_bend_rad(CoupledPair::Overrides overrides) {
  // Three quarters of the run: two turns of the crank, the last one at full speed.
  if (!test::long_tests()) overrides.push_back({"run.duration_s", "0.75"});
  CoupledPair pair(kScenario, overrides);
  double largest = 0.0;
  const RunReport report = pair.run(Mode::Inproc, [&](const Sample& sample) {
    largest = std::max(largest, sample.motions[0].q_WP.angularDistance(sample.motions[1].q_WP));
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_EQ(report.not_converged_steps, 0);
  return largest;
}

// A pinned rod under its own lateral inertia q = ρ A r ω² sin θ has end slopes q l³/(24 E I) each,
// against each other 2 × 35 N/m × 0.027 m³ / (24 × 0.34 N m²) = 0.23 rad if it were slow, pinned at
// the rod's own ends and free of locking: some 0.1 rad must be seen.
TEST(SliderCrank, ConvergesInAllIterativeSchemesAndItsRodBendsVisibly) {
  const double bend_rad = largest_bend_rad({{"coupling.scheme", "interface_jacobian"}});
  EXPECT_GT(bend_rad, 0.1);
  EXPECT_LT(bend_rad, 0.5);
  for (const char* relaxation : {"aitken", "constant"}) {
    // The schemes solve the same equations to 1e-12 of the wrenches.
    EXPECT_NEAR(
        largest_bend_rad({{"coupling.scheme", "implicit"}, {"coupling.relaxation", relaxation}}),
        bend_rad, 1e-9)
        << relaxation;
  }
}

}  // namespace
}  // namespace tandem::coupled_test
