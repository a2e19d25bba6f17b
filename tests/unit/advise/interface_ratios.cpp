// The measured strength of a coupling against closed forms: a free mass m that carries a mass μ and
// a spring k has the gain G = −(μ + H² k)/m.

#include "orchestrator/advise/interface_ratios.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/mock_sides.h"

namespace tandem::orchestrator {
namespace {

constexpr double kRigid_kg = 2.0, kFlexible_kg = 0.3, kStiffness = 500.0;

InterfaceRatios ratios_at(double step_s, double fem_kg = kFlexible_kg) {
  test::MassMbs mbs(kRigid_kg, {.x = 0.01, .v = 1.0});
  test::MassSpringFem fem(fem_kg, kStiffness);
  return measure_ratios(mbs, fem, sim_time_from_seconds(step_s));
}

TEST(InterfaceRatios, CouplingRatioIsThatOfTheSplitOscillator) {
  for (const double step_s : {1e-4, 1e-2, 0.1}) {
    const double kappa = (kFlexible_kg + step_s * step_s * kStiffness) / kRigid_kg;
    EXPECT_NEAR(ratios_at(step_s).coupling_ratio(), kappa, 1e-12 * kappa);
  }
}

TEST(InterfaceRatios, PortFeelsBothMassesAndTheSpring) {
  const double step_s = 1e-2;
  const InterfaceRatios ratios = ratios_at(step_s);
  ASSERT_EQ(ratios.ports.size(), 1U);
  EXPECT_EQ(ratios.ports[0].name, "p");
  EXPECT_NEAR(ratios.ports[0].rigid_kg, kRigid_kg, 1e-12);
  EXPECT_NEAR(ratios.ports[0].flexible_kg, kFlexible_kg + step_s * step_s * kStiffness, 1e-12);
  EXPECT_NEAR(ratios.ports[0].stiffness_N_per_m, kStiffness, 1e-9);
}

TEST(InterfaceRatios, AmplificationPassesOneWhereTheoryHasTheLimit) {
  // κ = 1 for hold and 1/3 for linear prediction. H → 0 leaves κ = μ/m.
  for (const auto& [prediction, limit] :
       {std::pair{Prediction::Hold, 1.0}, std::pair{Prediction::Linear, 1.0 / 3.0}}) {
    const double step_s = 1e-6;  // the spring adds 1e-9 of the inertia
    EXPECT_LT(explicit_amplification(ratios_at(step_s, 0.999 * limit * kRigid_kg), prediction),
              1.0);
    EXPECT_GT(explicit_amplification(ratios_at(step_s, 1.001 * limit * kRigid_kg), prediction),
              1.0);
  }
}

TEST(InterfaceRatios, SidesAreInTheirInitialStateAfterwards) {
  test::MassMbs mbs(kRigid_kg, {.x = 0.01, .v = 1.0});
  test::MassSpringFem fem(kFlexible_kg, kStiffness);
  const InterfaceRatios first = measure_ratios(mbs, fem, sim_time_from_seconds(1e-2));
  EXPECT_EQ(mbs.observe().energy.kinetic_J, 0.5 * kRigid_kg);
  EXPECT_EQ(first.coupling_ratio(),
            measure_ratios(mbs, fem, sim_time_from_seconds(1e-2)).coupling_ratio());
}

TEST(InterfaceRatios, SideWithoutDerivativeIsRefusedByName) {
  test::MassMbs mbs(kRigid_kg, {}, /* can_linearize = */ false);
  test::MassSpringFem fem(kFlexible_kg, kStiffness);
  try {
    (void)measure_ratios(mbs, fem, sim_time_from_seconds(1e-2));
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    EXPECT_NE(std::string(error.what()).find("'mbs'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace tandem::orchestrator
