#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/split_oscillator.h"

// Adaptive steps that the tolerance would have shorter than min_step_s are made, and counted.
namespace tandem {
namespace {

RunReport adaptive_run(double tolerance) {
  test::SplitOscillator c{.fem_kg = 0.2, .stiffness = 400.0, .duration_s = 0.1, .step_s = 1e-3};
  c.coupling = {.scheme = SchemeKind::ExplicitSerial, .prediction = Prediction::Hold};
  c.coupling.adaptive.tolerance = tolerance;
  return run(c);
}

// The prediction of a swinging pair is wrong by more than 1e-12 in every step but a lucky one.
TEST(StepsBeyondTolerance, OfATooTightOneAreNearlyAll) {
  const RunReport report = adaptive_run(1e-12);
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_GT(report.steps_beyond_tolerance, 9 * report.macro_steps / 10);
  EXPECT_LE(report.steps_beyond_tolerance, report.macro_steps);
  EXPECT_EQ(to_json(report).at("steps_beyond_tolerance"), report.steps_beyond_tolerance);
}

TEST(StepsBeyondTolerance, AreNoneWhereTheToleranceIsMet) {
  const RunReport report = adaptive_run(0.5);
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_EQ(report.steps_beyond_tolerance, 0);
}

}  // namespace
}  // namespace tandem
