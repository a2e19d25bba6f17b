// Adaptive macro steps on the split oscillator.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "protocol/schemes/step_controller.h"
#include "tests/support/split_oscillator.h"

namespace tandem {
namespace {

using test::Journals;
using Case = test::SplitOscillator;

Case adaptive_case(SchemeKind scheme, double tolerance) {
  // κ = 0.2 at H = 0: the explicit schemes are stable at every step that is taken.
  Case c{.fem_kg = 0.2, .stiffness = 400.0, .duration_s = 0.5, .step_s = 1e-3};
  c.coupling = {.scheme = scheme, .prediction = Prediction::Hold};
  if (scheme == SchemeKind::Implicit || scheme == SchemeKind::InterfaceNewton) {
    c.coupling.motion_prediction = Prediction::Hold;
  }
  c.coupling.relaxation = Relaxation::IqnIls;
  c.coupling.adaptive.tolerance = tolerance;
  c.coupling.adaptive.max_step = sim_time_from_seconds(0.02);
  return c;
}

/// Distance in the phase plane from the exact solution of (m + μ) ẍ = −k x.
double exact_distance(const Case& c, const RunReport& report) {
  const double w = std::sqrt(c.stiffness / (c.mbs_kg + c.fem_kg)), t = c.duration_s;
  const double x = 0.01 * std::cos(w * t) + 1.0 / w * std::sin(w * t);
  const double v = -0.01 * w * std::sin(w * t) + std::cos(w * t);
  return std::hypot(report.motions[0].p_WP.x() - x, (report.motions[0].v_WP.x() - v) / w);
}

const AdaptiveParams kTight{.tolerance = 1e-3};

class AdaptiveScheme : public testing::TestWithParam<SchemeKind> {};

TEST_P(AdaptiveScheme, StepsAreMultiplesOfTheShortestAndMeetTheEnd) {
  const Case c = adaptive_case(GetParam(), 0.02);
  Journals journals;
  const RunReport report = run(c, journals);
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_EQ(report.simulated, sim_time_from_seconds(c.duration_s));
  SimTime sum{}, shortest = report.simulated, longest{};
  for (std::size_t n = 1; n < journals.steps.size(); ++n) {
    const SimTime H = journals.steps[n].step.step;
    EXPECT_EQ(H % (sim_time_from_seconds(c.step_s) / 32), SimTime{});
    sum += H;
    EXPECT_EQ(journals.steps[n].step.time, sum);
    shortest = std::min(shortest, H);
    longest = std::max(longest, H);
  }
  EXPECT_EQ(sum, report.simulated);
  EXPECT_GT(longest, 2 * shortest);  // it did adapt
}

TEST_P(AdaptiveScheme, ATighterToleranceGivesASmallerError) {
  double last = 1.0;
  for (double tolerance : {0.1, 0.02, 0.004}) {
    const Case c = adaptive_case(GetParam(), tolerance);
    const double error = exact_distance(c, run(c));
    EXPECT_LT(error, 0.6 * last) << tolerance;
    last = error;
  }
}

TEST_P(AdaptiveScheme, GivesTheSameBitsAgain) {
  const Case c = adaptive_case(GetParam(), 0.01);
  const RunReport a = run(c), b = run(c);
  EXPECT_EQ(a.macro_steps, b.macro_steps);
  EXPECT_EQ(a.rejected_steps, b.rejected_steps);
  EXPECT_EQ(stack(a.wrenches), stack(b.wrenches));
}

INSTANTIATE_TEST_SUITE_P(All, AdaptiveScheme,
                         testing::Values(SchemeKind::ExplicitSerial, SchemeKind::ExplicitParallel,
                                         SchemeKind::Implicit, SchemeKind::InterfaceNewton));

TEST(StepController, RejectsAndShortensUntilTheShortestStepAndThenAccepts) {
  StepController controller(
      {.scheme = SchemeKind::ExplicitSerial, .prediction = Prediction::Hold, .adaptive = kTight},
      sim_time_from_seconds(1e-3));
  MacroStepEnd end{.outcome = Outcome::Done, .motions = MotionSet(1), .wrenches = WrenchSet(1)};
  end.motions[0].v_WP.x() = 1.0;
  end.wrenches[0].f_P_W.x() = 1.0;
  // Nothing was predicted: all of the power is wrong.
  const InterfaceState begin{.motions = end.motions, .wrenches = WrenchSet(1)};
  SimTime H = controller.step(sim_time_from_seconds(1.0));
  for (int n = 0; n < 20 && !controller.accepts(H, end, begin); ++n) {
    const SimTime next = controller.step(sim_time_from_seconds(1.0));
    EXPECT_LT(next, H);
    H = next;
  }
  EXPECT_EQ(H, sim_time_from_seconds(1e-3) / 32);
}

TEST(StepController, HalvesAStepThatFailed) {
  StepController controller({.scheme = SchemeKind::ExplicitSerial, .adaptive = kTight},
                            sim_time_from_seconds(1e-3));
  const MacroStepEnd end{.outcome = Outcome::Failed};
  EXPECT_FALSE(controller.accepts(sim_time_from_seconds(1e-3), end, {}));
  EXPECT_NEAR(to_seconds(controller.step(sim_time_from_seconds(1.0))), 4e-4, 1e-4);
}

// A wave that no step resolves makes wrenches jump by as much as they are, however short the step;
// the velocities stay smooth, and so do the steps of a converged scheme.
TEST(StepController, ConvergedSchemesDoNotChaseWavesInTheWrenches) {
  for (const SchemeKind scheme : {SchemeKind::ExplicitSerial, SchemeKind::InterfaceNewton}) {
    StepController controller({.scheme = scheme, .adaptive = {.tolerance = 0.05}},
                              sim_time_from_seconds(1e-3));
    InterfaceState begin{.motions = MotionSet(1), .wrenches = WrenchSet(1)};
    begin.motions[0].v_WP.x() = 1.0;
    int accepted = 0;
    for (int n = 0; n < 20; ++n) {
      MacroStepEnd end{
          .outcome = Outcome::Done, .motions = begin.motions, .wrenches = WrenchSet(1)};
      end.wrenches[0].f_P_W.x() = n % 2 == 0 ? 1.5 : 0.5;
      accepted += controller.accepts(sim_time_from_seconds(1e-3), end, begin) ? 1 : 0;
      begin.wrenches = end.wrenches;
    }
    EXPECT_EQ(accepted, scheme == SchemeKind::InterfaceNewton ? 20 : 0);
  }
}

TEST(Adaptive, RejectedAttemptsAreInTheJournalAndInTheIterations) {
  Case c = adaptive_case(SchemeKind::ExplicitSerial, 1e-3);
  c.coupling.adaptive.min_step = sim_time_from_seconds(1e-5);
  Journals journals;
  const RunReport report = run(c, journals);
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_GT(report.rejected_steps, 0);
  EXPECT_EQ(report.iterations_total, report.macro_steps + report.rejected_steps);
  std::int64_t discarded = 0;
  for (const wire::StepJournal& journal : journals.steps) {
    for (const wire::CallRecord& call : journal.calls) discarded += call.accepted ? 0 : 1;
  }
  EXPECT_EQ(discarded, 2 * report.rejected_steps);
}

}  // namespace
}  // namespace tandem
