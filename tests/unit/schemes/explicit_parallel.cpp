#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/split_oscillator.h"

namespace tandem {
namespace {

using test::Journals;
using test::MassMbs;
using test::MassSpringFem;
using Case = test::SplitOscillator;

CouplingParams parallel(Prediction wrenches, Prediction motions) {
  return {
      .scheme = SchemeKind::ExplicitParallel, .prediction = wrenches, .motion_prediction = motions};
}

/// A mock that writes down when its advances begin (small letter) and finish (capital).
template <class Side, class In, class Out>
class Traced final : public Side {
 public:
  template <class... Args>
  Traced(std::string& trace, const char* letters, Args... args)
      : Side(args...), trace_(trace), letters_(letters) {}
  void begin_advance(const StepRequest<In>& request) override {
    trace_ += letters_[0];
    Side::begin_advance(request);
  }
  StepResult<Out> finish_advance() override {
    trace_ += letters_[1];
    return Side::finish_advance();
  }

 private:
  std::string& trace_;
  const char* letters_;
};

TEST(ExplicitParallel, StartsBothSidesBeforeItWaitsForEither) {
  std::string trace;
  Traced<MassMbs, WrenchSet, MotionSet> mbs(trace, "mM", 1.0, MassMbs::State{.v = 1.0});
  Traced<MassSpringFem, MotionSet, WrenchSet> fem(trace, "fF", 0.1, 10.0);
  const auto params = scheme_run({sim_time_from_seconds(0.002), sim_time_from_seconds(0.001)},
                                 parallel(Prediction::Linear, Prediction::Linear));
  Journals journals;
  EXPECT_EQ(run_coupled(params, {mbs}, {fem}, journals).status, RunStatus::Done);
  EXPECT_EQ(trace, "fmMFfmMF");
}

TEST(ExplicitParallel, GivesEachSideThePredictionOfTheOther) {
  Case c{.fem_kg = 0.1, .stiffness = 10.0, .duration_s = 0.004};
  c.coupling = parallel(Prediction::Quadratic, Prediction::Linear);
  Journals journals;
  ASSERT_EQ(run(c, journals).status, RunStatus::Done);
  // Calls of a macro step: the multibody side's, then the flexible side's.
  const auto motion = [&](std::size_t n) { return journals.steps[n].calls[0].motions.end[0]; };
  const auto wrench = [&](std::size_t n) { return journals.steps[n].calls[1].wrenches.end[0]; };
  const double v = 2.0 * motion(3).v_WP.x() - motion(2).v_WP.x();
  const double f = 3.0 * wrench(3).f_P_W.x() - 3.0 * wrench(2).f_P_W.x() + wrench(1).f_P_W.x();
  const auto& calls = journals.steps[4].calls;
  EXPECT_NEAR(calls[1].motions.end[0].v_WP.x(), v, 1e-14);
  EXPECT_NEAR(calls[0].wrenches.end[0].f_P_W.x(), f, 1e-12 * std::abs(f));
}

// κ = 0.1 so that start-up transients die out at once; two-sided over four halvings. Hold leaves
// errors of order H in wrench and motion; linear prediction leaves those of the two integrators,
// also of order 1.
TEST(ExplicitParallel, ConvergesToTheCoupledStepWithOrderOneOrTwo) {
  for (const Prediction prediction : {Prediction::Hold, Prediction::Linear}) {
    const double order = prediction == Prediction::Hold ? 1.0 : 2.0;
    double last_error = 0.0;
    for (int level = 0; level < 5; ++level) {
      Case c{.fem_kg = 0.1,
             .stiffness = 400.0,
             .duration_s = 0.16,
             .step_s = 1e-3 / std::pow(2, level)};
      c.coupling = parallel(prediction, prediction);
      const double error = phase_distance(c, run(c));
      if (level > 0) {
        EXPECT_NEAR(std::log2(last_error / error), order, 0.15)
            << "level " << level << ", degree " << order - 1.0;
      }
      last_error = error;
    }
  }
}

TEST(ExplicitParallel, IsStoppedBeyondTheMassRatio) {
  Case c{.fem_kg = 1.5, .stiffness = 10.0};
  c.coupling = parallel(Prediction::Hold, Prediction::Hold);
  const RunReport report = run(c);
  EXPECT_EQ(report.status, RunStatus::Diverged);
  EXPECT_NE(report.message.find("port 'p'"), std::string::npos) << report.message;
}

TEST(ExplicitParallel, FinishesBothSidesWhenOneFails) {
  MassMbs mbs(1.0, {.v = 1.0});
  MassSpringFem fem(0.1, 1.0);
  fem.fail_at_advance = 2;
  const auto params = scheme_run({sim_time_from_seconds(0.01), sim_time_from_seconds(0.001)},
                                 parallel(Prediction::Hold, Prediction::Hold));
  Journals journals;
  const RunReport report = run_coupled(params, {mbs}, {fem}, journals);
  EXPECT_EQ(report.status, RunStatus::SolverFailed);
  EXPECT_EQ(mbs.advances, 2);
  EXPECT_NE(report.message.find("fails on purpose"), std::string::npos) << report.message;
}

}  // namespace
}  // namespace tandem
