#include "protocol/scenario/law.h"

#include <cmath>
#include <numbers>

#include "tests/unit/scenario/support.h"

namespace tandem::scenario {
namespace {

Section table() {
  Section root;
  root.title = "Test";
  root.keys = {law("torque_Nm", "N·m").must()};
  return root;
}

Law law_of(const std::string& text) {
  return read_law(load_text("torque_Nm: " + text, table()).root.section("torque_Nm"));
}

TEST(Law, PlainNumberIsAConstantLaw) {
  const Law law = law_of("-2.5");
  EXPECT_EQ(law(0.0), -2.5);
  EXPECT_EQ(law(1e6), -2.5);
}

TEST(Law, ConstantIsTheDefaultKind) { EXPECT_EQ(law_of("{value: 4}")(3.0), 4.0); }

TEST(Law, RampHoldsOutsideAndIsLinearBetween) {
  const Law law = law_of("{kind: ramp, begin_s: 1, end_s: 3, value_begin: -2, value_end: 6}");
  EXPECT_EQ(law(0.0), -2.0);
  EXPECT_EQ(law(1.0), -2.0);
  EXPECT_EQ(law(1.5), 0.0);  // all numbers are exact in binary
  EXPECT_EQ(law(2.0), 2.0);
  EXPECT_EQ(law(3.0), 6.0);
  EXPECT_EQ(law(9.0), 6.0);
}

TEST(Law, RampStartsFromZeroAtZeroByDefault) {
  EXPECT_EQ(law_of("{kind: ramp, end_s: 2, value_end: 8}")(0.5), 2.0);
}

TEST(Law, HarmonicFollowsOffsetAmplitudeFrequencyAndPhase) {
  const Law law =
      law_of("{kind: harmonic, offset: 1, amplitude: 2, frequency_Hz: 0.25, phase_rad: 0.5}");
  EXPECT_DOUBLE_EQ(law(0.0), 1.0 + 2.0 * std::sin(0.5));
  // A quarter period on, the sine has become the cosine; tolerance: rounding of π/2 + 0.5.
  EXPECT_NEAR(law(1.0), 1.0 + 2.0 * std::cos(0.5), 4e-16 * 4);
  EXPECT_NEAR(law(4.0), law(0.0), 4e-15);
}

TEST(Law, TableIsLinearBetweenPointsAndConstantOutside) {
  const Law law = law_of("{kind: table, times_s: [0, 1, 3], values: [5, 7, -1]}");
  EXPECT_EQ(law(-1.0), 5.0);
  EXPECT_EQ(law(0.0), 5.0);
  EXPECT_EQ(law(0.5), 6.0);
  EXPECT_EQ(law(1.0), 7.0);
  EXPECT_EQ(law(2.5), 1.0);
  EXPECT_EQ(law(3.0), -1.0);
  EXPECT_EQ(law(10.0), -1.0);
}

TEST(Law, TableOfOnePointIsConstant) {
  EXPECT_EQ(law_of("{kind: table, times_s: [2], values: [5]}")(0.0), 5.0);
}

// Means of straight pieces are those of trapezoids; all numbers are exact in binary.
TEST(Law, MeanIsThatOfEveryPieceOfTheLaw) {
  EXPECT_EQ(law_of("-2.5").mean(1.0, 3.0), -2.5);
  const Law ramp = law_of("{kind: ramp, begin_s: 1, end_s: 3, value_begin: -2, value_end: 6}");
  EXPECT_EQ(ramp.mean(0.0, 1.0), -2.0);
  EXPECT_EQ(ramp.mean(1.5, 2.5), 2.0);
  EXPECT_EQ(ramp.mean(0.0, 2.0), -1.0);  // −2 for a second, then 0 in the mean
  EXPECT_EQ(ramp.mean(0.0, 4.0), 2.0);
  const Law table = law_of("{kind: table, times_s: [0, 1, 3], values: [5, 7, -1]}");
  EXPECT_EQ(table.mean(-1.0, 0.0), 5.0);
  EXPECT_EQ(table.mean(0.5, 1.5), 6.25);  // 6.5 and 6
  EXPECT_EQ(table.mean(-1.0, 4.0), 3.2);  // 5 + 6 + 2 · 3 − 1 over 5 s
}

// ∫ sin = −cos: over half a period the mean is 2/π, over a whole one nothing.
TEST(Law, MeanOfAHarmonicIsItsIntegral) {
  const Law law = law_of("{kind: harmonic, offset: 3, amplitude: 2, frequency_Hz: 0.5}");
  EXPECT_NEAR(law.mean(0.0, 1.0), 3.0 + 2.0 * 2.0 / std::numbers::pi, 1e-15);
  EXPECT_NEAR(law.mean(0.3, 2.3), 3.0, 1e-15);
  EXPECT_NEAR(law.mean(0.25, 0.25 + 1e-9), law(0.25), 1e-8);
}

TEST(Law, KeysOfAnotherKindAreRefused) {
  expect_defect("torque_Nm: {kind: ramp, end_s: 1, value_end: 2, amplitude: 3}", table(),
                "scenario.yaml:1:60: torque_Nm.amplitude: is not used when kind is ramp, only when "
                "it is harmonic. Remove it or change kind.");
}

TEST(Law, MissingKeysOfTheKindAreNamed) {
  expect_defect("torque_Nm: {kind: harmonic, amplitude: 3}", table(),
                "scenario.yaml:1:12: torque_Nm.frequency_Hz: is missing. Give a number in Hz.");
}

TEST(Law, UnknownKindHasASuggestion) {
  expect_defect("torque_Nm: {kind: harmonix, amplitude: 3}", table(),
                "scenario.yaml:1:19: torque_Nm.kind: 'harmonix' is not known. It must be one of "
                "constant, ramp, harmonic, table. Did you mean 'harmonic'?");
}

TEST(Law, RampNeedsADuration) {
  expect_defect("torque_Nm: {kind: ramp, begin_s: 2, end_s: 2, value_end: 2}", table(),
                "scenario.yaml:1:44: torque_Nm.end_s: 2 s is not after begin_s = 2 s. The ramp "
                "needs a duration.");
}

TEST(Law, TableNeedsIncreasingTimes) {
  expect_defect("torque_Nm: {kind: table, times_s: [0, 2, 2], values: [1, 2, 3]}", table(),
                "scenario.yaml:1:35: torque_Nm.times_s: entry 2 (2 s) is not after entry 1 (2 s). "
                "Times must increase strictly.");
}

TEST(Law, TableNeedsOneValuePerTime) {
  expect_defect("torque_Nm: {kind: table, times_s: [0, 2, 3], values: [1, 2]}", table(),
                "scenario.yaml:1:54: torque_Nm.values: has 2 numbers for 3 times_s. Give one value "
                "per time.");
}

TEST(Law, EmptyTableIsRefused) {
  expect_defect("torque_Nm: {kind: table, times_s: [], values: [1]}", table(),
                "scenario.yaml:1:35: torque_Nm.times_s: has 0 entries. It must be a list of at "
                "least 1 number.");
}

}  // namespace
}  // namespace tandem::scenario
