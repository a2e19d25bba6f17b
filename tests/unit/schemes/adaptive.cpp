// Adaptive macro steps on the split oscillator.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

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

const std::vector<PortInfo> kOnePort = {{.name = "p", .length_m = 0.5}};
const SimTime kSecond = sim_time_from_seconds(1.0);

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

// Steps follow the square root of the tolerance or faster, and the error the steps: a fifth of the
// tolerance gives less than 1/√5 = 0.45 of the error.
TEST_P(AdaptiveScheme, ATighterToleranceGivesASmallerError) {
  double last = 1.0;
  for (double tolerance : {0.01, 0.002, 0.0004}) {
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

/// What a step of H from rest did, and what the step of H before it added to the twist.
struct JudgedStep {
  double H_s = 0.01;
  Eigen::Vector3d moved = Eigen::Vector3d::Zero(), dv = Eigen::Vector3d::Zero();
  Eigen::Vector3d turned = Eigen::Vector3d::Zero(), dw = Eigen::Vector3d::Zero();
  Eigen::Vector3d past_dv = Eigen::Vector3d::Zero(), past_dw = Eigen::Vector3d::Zero();
};

/// The step (s) which the controller takes next, in units of 1 µs; 0 = it has rejected this one.
double next_step_s(const JudgedStep& judged, double tolerance, std::vector<PortInfo> ports,
                   const MotionSet& start) {
  CouplingParams coupling{.adaptive = {.tolerance = tolerance}};
  coupling.adaptive.min_step = sim_time_from_seconds(1e-6);
  const SimTime H = sim_time_from_seconds(judged.H_s);
  StepController controller(coupling, H, std::move(ports), start);
  InterfaceState begin{.time = sim_time_from_seconds(0.1),
                       .motions = start,
                       .wrenches = WrenchSet(start.size()),
                       .history = {{.time = sim_time_from_seconds(0.1) - H,
                                    .motions = start,
                                    .wrenches = WrenchSet(start.size())}}};
  begin.history[0].motions[0].v_WP = -judged.past_dv;
  begin.history[0].motions[0].w_WP = -judged.past_dw;
  MacroStepEnd end{.outcome = Outcome::Done, .motions = start, .wrenches = WrenchSet(start.size())};
  end.motions[0].p_WP += judged.moved;
  end.motions[0].v_WP = judged.dv;
  end.motions[0].q_WP = Eigen::AngleAxisd(judged.turned.norm(), Eigen::Vector3d::UnitZ());
  end.motions[0].w_WP = judged.dw;
  return controller.accepts(H, end, begin) ? to_seconds(controller.step(kSecond)) : 0.0;
}

/// H · 0.9 ρ^−0.7, the first step's answer to the ratio ρ.
double answer_s(double H_s, double ratio) { return H_s * 0.9 * std::pow(ratio, -0.7); }

/// A step of 1 ms at 1 m/s whose answer of 1 N was not applied at all.
struct EnergyStep {
  MacroStepEnd end{.outcome = Outcome::Done,
                   .motions = MotionSet(1),
                   .wrenches = WrenchSet(1),
                   .applied = WrenchSet(1)};
  InterfaceState begin{.motions = MotionSet(1), .wrenches = WrenchSet(1)};
  EnergyStep() {
    begin.motions[0].v_WP.x() = end.motions[0].v_WP.x() = 1.0;
    end.motions[0].p_WP.x() = 1e-3;
    end.wrenches[0].f_P_W.x() = 1.0;
    begin.history = {
        {.time = -sim_time_from_seconds(1e-3), .motions = begin.motions, .wrenches = WrenchSet(1)}};
  }
};

// 1 mJ is created, the largest wrench over the size is 0.5 J: with the tolerance 8e-3 a quarter.
TEST(StepController, MeasuresTheEnergyThatAnExplicitStepCreates) {
  const EnergyStep step;
  const auto next_s = [&](SchemeKind scheme, double tolerance) {
    CouplingParams coupling{.scheme = scheme, .adaptive = {.tolerance = tolerance}};
    coupling.adaptive.min_step = sim_time_from_seconds(1e-6);
    StepController controller(coupling, sim_time_from_seconds(1e-3), kOnePort, step.begin.motions);
    const bool accepted = controller.accepts(sim_time_from_seconds(1e-3), step.end, step.begin);
    return accepted ? to_seconds(controller.step(kSecond)) : 0.0;
  };
  for (const SchemeKind scheme :
       {SchemeKind::ExplicitSerial, SchemeKind::ExplicitParallel, SchemeKind::Tlm}) {
    EXPECT_NEAR(next_s(scheme, 8e-3), answer_s(1e-3, 0.5), 1e-6);
    EXPECT_EQ(next_s(scheme, 1.9e-3), 0.0);
  }
  // Converged schemes are not asked for it.
  EXPECT_NEAR(next_s(SchemeKind::InterfaceNewton, 1.9e-3), 2e-3, 1e-9);
}

// A force that begins within a step of 16 H₀ from rest: nothing moves yet, no energy is created,
// and the whole impulse is lost, 16 times that of the first step.
TEST(StepController, MeasuresTheImpulseThatAnExplicitStepDoesNotGive) {
  const SimTime H0 = sim_time_from_seconds(1e-3);
  for (const SchemeKind scheme :
       {SchemeKind::ExplicitSerial, SchemeKind::ExplicitParallel, SchemeKind::InterfaceNewton}) {
    StepController controller({.scheme = scheme, .adaptive = {.tolerance = 1e-3}}, H0, kOnePort,
                              MotionSet(1));
    const InterfaceState begin{.motions = MotionSet(1), .wrenches = WrenchSet(1)};
    MacroStepEnd end{.outcome = Outcome::Done,
                     .motions = MotionSet(1),
                     .wrenches = WrenchSet(1),
                     .applied = WrenchSet(1),
                     .residual_N = 300.0};
    end.wrenches[0].f_P_W.x() = 300.0;
    const bool accepted = controller.accepts(16 * H0, end, begin);
    EXPECT_EQ(accepted, scheme == SchemeKind::InterfaceNewton);  // which has no such defect
    if (accepted) continue;
    EXPECT_LE(controller.step(kSecond), 16 * H0 * 3 / 10);
    EXPECT_TRUE(controller.accepts(H0, end, begin));
  }
}

// 50 ms at up to 32 ms a step: without the event the second step would pass it.
TEST(Adaptive, EventsAreStepEndsAndExplicitStepsBeginAnew) {
  for (const SchemeKind scheme : {SchemeKind::ExplicitSerial, SchemeKind::InterfaceNewton}) {
    const Case c = adaptive_case(scheme, 1.0);
    test::MassMbs mbs(c.mbs_kg, {.x = 0.01, .v = 1.0});
    test::MassSpringFem fem(c.fem_kg, c.stiffness);
    CoupledRunParams params =
        scheme_run({sim_time_from_seconds(0.2), sim_time_from_seconds(1e-3)}, c.coupling);
    const SimTime unit = sim_time_from_seconds(1e-3) / 32;
    const SimTime event = 1600 * unit;  // 50 ms
    params.run.events = {unit / 2, event, event + unit + unit / 2, sim_time_from_seconds(0.3)};
    Journals journals;
    const RunReport report = run_coupled(params, {mbs}, {fem}, journals);
    ASSERT_EQ(report.status, RunStatus::Done) << report.message;
    std::vector<SimTime> ends;
    SimTime longest{};
    for (const wire::StepJournal& journal : journals.steps) {
      ends.push_back(journal.step.time);
      const bool after = journal.step.time - journal.step.step == event + unit;
      if (after && scheme == SchemeKind::ExplicitSerial) {
        EXPECT_LE(journal.step.step, sim_time_from_seconds(1e-3));
      }
      longest = std::max(longest, journal.step.step);
    }
    EXPECT_EQ(std::count(ends.begin(), ends.end(), event), 1);
    // Between two units the one before.
    EXPECT_EQ(std::count(ends.begin(), ends.end(), event + unit), 1);
    EXPECT_GT(longest, sim_time_from_seconds(1e-3));
  }
}

TEST(StepController, RejectsAndShortensUntilTheShortestStepAndThenAccepts) {
  const EnergyStep step;
  StepController controller({.scheme = SchemeKind::ExplicitSerial, .adaptive = {.tolerance = 1e-9}},
                            sim_time_from_seconds(1e-3), kOnePort, MotionSet(1));
  SimTime H = controller.step(kSecond);
  for (int n = 0; n < 20 && !controller.accepts(H, step.end, step.begin); ++n) {
    const SimTime next = controller.step(kSecond);
    EXPECT_LT(next, H);
    H = next;
  }
  EXPECT_EQ(H, sim_time_from_seconds(1e-3) / 32);
}

// Whether or not another step went before: a failed one has no wrenches.
TEST(StepController, HalvesAStepThatFailed) {
  const EnergyStep step;
  for (const bool first : {true, false}) {
    StepController controller({.scheme = SchemeKind::ExplicitSerial, .adaptive = {.tolerance = 1}},
                              sim_time_from_seconds(1e-3), kOnePort, MotionSet(1));
    if (!first) {
      EXPECT_TRUE(controller.accepts(sim_time_from_seconds(1e-3), step.end, step.begin));
    }
    const MacroStepEnd end{.outcome = Outcome::Failed};
    EXPECT_FALSE(controller.accepts(sim_time_from_seconds(1e-3), end, step.begin));
    EXPECT_NEAR(to_seconds(controller.step(kSecond)), 4e-4, 1e-4);
  }
}

TEST(StepController, EndsWithTwoEqualStepsInPlaceOfAShortRest) {
  const SimTime H = sim_time_from_seconds(1e-3);
  const StepController controller({.adaptive = {.tolerance = 1}}, H, kOnePort, MotionSet(1));
  EXPECT_EQ(controller.step(kSecond), H);
  EXPECT_EQ(controller.step(2 * H), H);
  EXPECT_EQ(controller.step(sim_time_from_seconds(1.5e-3)), sim_time_from_seconds(7.5e-4));
  EXPECT_EQ(controller.step(H), H);
  EXPECT_EQ(controller.step(H / 4), H / 4);
}

// A wave that no step resolves makes wrenches jump by as much as they are, however short the step;
// the motions stay smooth, and so do the steps of a converged scheme.
TEST(StepController, ConvergedSchemesDoNotChaseWavesInTheWrenches) {
  for (const SchemeKind scheme : {SchemeKind::ExplicitSerial, SchemeKind::InterfaceNewton}) {
    InterfaceState begin{.motions = MotionSet(1), .wrenches = WrenchSet(1)};
    begin.motions[0].v_WP.x() = 1.0;
    StepController controller({.scheme = scheme, .adaptive = {.tolerance = 1e-3}},
                              sim_time_from_seconds(1e-3), kOnePort, begin.motions);
    int accepted = 0;
    for (int n = 0; n < 20; ++n) {
      MacroStepEnd end{
          .outcome = Outcome::Done, .motions = begin.motions, .wrenches = WrenchSet(1)};
      end.applied = begin.wrenches;
      end.motions[0].p_WP.x() += 1e-3;
      end.wrenches[0].f_P_W.x() = n % 2 == 0 ? 1.5 : 0.5;
      accepted += controller.accepts(sim_time_from_seconds(1e-3), end, begin) ? 1 : 0;
      begin.motions = end.motions;
      begin.wrenches = end.wrenches;
    }
    EXPECT_EQ(accepted, scheme == SchemeKind::InterfaceNewton ? 20 : 0);
  }
}

// v⁺ = a H, x⁺ = H v⁺: the local error of the first-order step is a H²/2 = 1e-4 m. Of the size
// 0.5 m times the tolerance 8e-4 that is a quarter: ρ = 1/2.
TEST(StepController, MeasuresThePositionErrorOfAFirstOrderStep) {
  const Eigen::Vector3d dv(0.0, 0.02, 0.0);
  const JudgedStep straight{.moved = 0.01 * dv, .dv = dv, .past_dv = dv};
  EXPECT_NEAR(next_step_s(straight, 8e-4, kOnePort, MotionSet(1)), answer_s(0.01, 0.5), 1e-6);
  EXPECT_EQ(next_step_s(straight, 1.9e-4, kOnePort, MotionSet(1)), 0.0);  // ρ > 1
  // An angle counts with the port length: twice the angle, the same error.
  const Eigen::Vector3d dw(0.0, 0.0, 0.04);
  const JudgedStep turning{.turned = 0.01 * dw, .dw = dw, .past_dw = dw};
  EXPECT_NEAR(next_step_s(turning, 8e-4, kOnePort, MotionSet(1)), answer_s(0.01, 0.5), 1e-6);
}

// Ports at opposite corners of a box of 3 m x 4 m x 12 m: the size is its diagonal of 13 m.
TEST(StepController, MeasuresErrorsAgainstTheSizeOfTheInterface) {
  MotionSet start(2);
  start[1].p_WP = {-3.0, 4.0, 12.0};
  const Eigen::Vector3d dv(0.02, 0.0, 0.0);
  const JudgedStep step{.moved = 0.01 * dv, .dv = dv, .past_dv = dv};
  const double tolerance = 1e-4 / 13.0 / 0.25;
  EXPECT_NEAR(next_step_s(step, tolerance, {kOnePort[0], kOnePort[0]}, start), answer_s(0.01, 0.5),
              1e-6);
}

// The trapezoidal rule leaves no d: x⁺ = H v⁺/2. With ȧ = 60 m/s³ the velocity departs from its
// linear prediction by ȧ H² and the position by ȧ H³/12 = 5e-6 m.
TEST(StepController, MeasuresTheErrorOfTheTrapezoidalRuleByTheVelocityItDidNotPredict) {
  const Eigen::Vector3d past_dv(0.02, 0.0, 0.0), dv = past_dv + Eigen::Vector3d(6e-3, 0.0, 0.0);
  const JudgedStep step{.moved = 0.005 * dv, .dv = dv, .past_dv = past_dv};
  EXPECT_NEAR(next_step_s(step, 4e-5, kOnePort, MotionSet(1)), answer_s(0.01, 0.5), 1e-6);
}

// κ grows with the step here, (μ + k H²)/m: at 0.2 s the fixed coupling is far beyond its limit.
// The tolerance allows any step.
TEST(Adaptive, ExplicitStepsStayBelowTheStabilityLimit) {
  for (const SchemeKind scheme : {SchemeKind::ExplicitSerial, SchemeKind::ExplicitParallel}) {
    Case c = adaptive_case(scheme, 1.0);
    c.duration_s = 20.0;
    c.step_s = 0.2;
    c.coupling.adaptive.max_step = sim_time_from_seconds(0.2);
    EXPECT_EQ(run(c).status, RunStatus::Done);
    c.coupling.adaptive.tolerance = 0.0;
    EXPECT_EQ(run(c).status, RunStatus::Diverged);
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
