#include "orchestrator/verdict/verdict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "protocol/driver/energy_range.h"

// The verdict on runs whose books are made up: both sides of every threshold.
namespace tandem::orchestrator {
namespace {

using Limits = VerdictLimits;

/// A run that turned 2 J over and lost nothing.
RunBooks sound() {
  RunBooks books;
  books.held_J = 2.0;
  books.external_work_J = 1.0;
  books.potential_change_J = 0.5;
  books.given_J = 1.5;
  books.exchanged_J = 3.0;
  books.macro_steps = 1000;
  books.largest_step_s = 1e-3;
  books.turning = "port 'hub'";
  return books;
}

struct Threshold {
  std::string cause;
  double limit;
  std::function<void(RunBooks&, double)> set;
};

void PrintTo(const Threshold& t, std::ostream* out) { *out << t.cause; }

class VerdictThreshold : public ::testing::TestWithParam<Threshold> {};

TEST_P(VerdictThreshold, IsKeptBelowAndNamedAbove) {
  const Threshold& threshold = GetParam();
  RunBooks below = sound();
  threshold.set(below, 0.999 * threshold.limit);
  EXPECT_TRUE(judge(below).clean()) << judge(below).text();

  RunBooks above = sound();
  threshold.set(above, 1.001 * threshold.limit);
  const Verdict verdict = judge(above);
  ASSERT_EQ(verdict.causes.size(), 1U) << verdict.text();
  const Cause& cause = verdict.causes.front();
  EXPECT_EQ(cause.name, threshold.cause);
  EXPECT_NEAR(cause.value, 1.001 * threshold.limit, 1e-12 * std::abs(threshold.limit));
  EXPECT_EQ(cause.threshold, threshold.limit);
  EXPECT_FALSE(cause.text.empty());
  EXPECT_TRUE(cause.remedy.ends_with(".")) << cause.remedy;
  EXPECT_TRUE(verdict.text().starts_with("done, but ")) << verdict.text();
}

TEST(Verdict, HoldsWhatTheIterationsLeftAgainstTheAccuracy) {
  RunBooks books = sound();
  books.accuracy = 1e-6;
  books.residual_part = 0.999e-6;
  EXPECT_TRUE(judge(books).clean()) << judge(books).text();
  books.residual_part = 1.001e-6;
  const Verdict verdict = judge(books);
  ASSERT_EQ(verdict.causes.size(), 1U) << verdict.text();
  EXPECT_EQ(verdict.causes.front().name, "residual");
  EXPECT_NE(verdict.text().find("lower fem.solver.tolerance"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Each, VerdictThreshold,
    ::testing::Values(
        // Parts of the 2 J that were held, and of the 1.5 J that were given.
        Threshold{"numerical_loss", Limits::kLost,
                  [](RunBooks& b, double part) { b.lost_J = b.lost_max_J = 2.0 * part; }},
        Threshold{"energy_growth", Limits::kMade,
                  [](RunBooks& b, double part) { b.made_max_J = 1.5 * part; }},
        Threshold{"balance_error", Limits::kBalanceError,
                  [](RunBooks& b, double part) { b.balance_error_max_J = 2.0 * part; }},
        Threshold{"contact", Limits::kBalanceError,
                  [](RunBooks& b, double part) {
                    b.balance_error_max_J = 2.0 * part;
                    b.contact = true;
                  }},
        Threshold{"turn_per_step", Limits::kTurn_rad,
                  [](RunBooks& b, double turn) { b.largest_turn_rad = turn; }},
        Threshold{"joint_gap", Limits::kJointGap,
                  [](RunBooks& b, double part) { b.joint_gap_part = part; }},
        Threshold{"elastic_turn", Limits::kElasticTurn_rad,
                  [](RunBooks& b, double turn) { b.elastic_turn_rad = turn; }},
        Threshold{"parasitic_mass", Limits::kParasiticMass,
                  [](RunBooks& b, double part) {
                    b.lightest_port_body_kg = 4.0;
                    b.parasitic_mass_kg = 4.0 * part;
                  }}),
    [](const auto& tested) { return tested.param.cause; });

TEST(Verdict, OfASoundRunIsDone) {
  const Verdict verdict = judge(sound());
  EXPECT_EQ(verdict.text(), "done");
  EXPECT_EQ(verdict.scale_J, 2.0);
  EXPECT_EQ(to_json(verdict).at("status"), "done");
  EXPECT_TRUE(to_json(verdict).at("causes").empty());
}

TEST(Verdict, NamesAnyStepThatDidNotConvergeWithWhatItsSolverSaid) {
  RunBooks books = sound();
  books.not_converged_steps = 1;
  books.not_converged_message = "PCG: residual 2 N. Raise fem.solver.max_iterations.";
  const Verdict verdict = judge(books);
  ASSERT_EQ(verdict.causes.size(), 1U);
  EXPECT_EQ(verdict.causes[0].name, "not_converged_steps");
  EXPECT_EQ(verdict.causes[0].remedy, books.not_converged_message);
}

TEST(Verdict, NamesAnyStepBeyondTheTolerance) {
  RunBooks books = sound();
  books.adaptive = true;
  EXPECT_TRUE(judge(books).clean());
  books.steps_beyond_tolerance = 1;
  ASSERT_EQ(judge(books).causes.size(), 1U);
  EXPECT_EQ(judge(books).causes[0].name, "steps_beyond_tolerance");
}

// 1e-20 J of a model at rest is no loss of 100 %.
TEST(Verdict, NamesMissesOfAPacedRunAboveOneInAThousand) {
  RunBooks books = sound();
  books.paced_steps = 10000;
  books.missed_steps = 10;
  books.missed_by = "fem";
  EXPECT_TRUE(judge(books).clean()) << judge(books).text();
  books.missed_steps = 11;
  const Verdict verdict = judge(books);
  ASSERT_EQ(verdict.causes.size(), 1U) << verdict.text();
  EXPECT_EQ(verdict.causes.front().name, "pace");
  EXPECT_NE(verdict.text().find("11 of 10000 macro steps"), std::string::npos) << verdict.text();
  EXPECT_NE(verdict.text().find("for fem"), std::string::npos) << verdict.text();
}

TEST(Verdict, SaysThatABudgetLeftTheResidual) {
  RunBooks books = sound();
  books.accuracy = 1e-6;
  books.residual_part = 1e-4;
  books.steps_out_of_budget = 7;
  const std::string text = judge(books).text();
  EXPECT_NE(text.find("7 of 1000 macro steps ended by coupling.max_evaluations"), std::string::npos)
      << text;
  EXPECT_NE(text.find("raise coupling.max_evaluations"), std::string::npos) << text;
}

TEST(Verdict, PassesOverRoundOffAtRest) {
  RunBooks books;
  books.held_J = 1e-20;
  books.lost_max_J = 1e-20;
  books.balance_error_max_J = 1e-20;
  books.made_max_J = 1e-20;
  books.still_J = 1e-9;
  EXPECT_TRUE(judge(books).clean()) << judge(books).text();
  books.still_J = 0.0;
  EXPECT_FALSE(judge(books).clean());
}

TEST(Verdict, DoesNotPassWhatIsNoNumber) {
  RunBooks books = sound();
  books.balance_error_max_J = std::nan("");
  EXPECT_FALSE(judge(books).clean());
}

// The remedy is one for the run at hand.
TEST(Verdict, RemedyOfALossNamesWhatIsStillOfFirstOrder) {
  RunBooks books = sound();
  books.lost_max_J = 1.0;
  const auto remedy = [&] { return judge(books).causes.at(0).remedy; };
  EXPECT_NE(remedy().find("mbs.integrator: verlet with fem.integrator.kind"), std::string::npos);
  books.mbs_second_order = true;
  EXPECT_EQ(remedy().find("mbs.integrator: verlet"), std::string::npos);
  EXPECT_NE(remedy().find("fem.integrator.kind: generalised_alpha"), std::string::npos);
  books.fem_second_order = true;
  EXPECT_EQ(remedy(), "lower run.macro_step_s.");
  books.reduced = true;
  EXPECT_NE(remedy().find("craig_bampton"), std::string::npos);
}

TEST(Verdict, RemedyOfGrowthUnderAnExplicitSchemeIsAnother) {
  RunBooks books = sound();
  books.made_max_J = 1.0;
  EXPECT_EQ(judge(books).causes.at(0).remedy, "lower run.macro_step_s.");
  books.explicit_scheme = true;
  EXPECT_NE(judge(books).causes.at(0).remedy.find("interface_jacobian"), std::string::npos);
}

TEST(Verdict, RemedyOfAnOpenBalanceIsIterationWhereTheStepHasNone) {
  RunBooks books = sound();
  books.balance_error_max_J = 1.0;
  EXPECT_EQ(judge(books).causes.at(0).remedy, "lower run.macro_step_s.");
  books.linearised = true;
  EXPECT_NE(judge(books).causes.at(0).remedy.find("newton_steps: 20"), std::string::npos);
}

TEST(Verdict, RemedyOfATurnIsTheStepThatMakesItSmall) {
  RunBooks books = sound();
  books.largest_turn_rad = 0.5;
  EXPECT_EQ(judge(books).causes.at(0).remedy, "lower run.macro_step_s to 0.0004 s or less.");
}

// Pre-tension takes no part; what it releases does.
TEST(EnergyRange, CountsStrainFromTheStart) {
  const EnergyBook start{.kinetic_J = 3.0, .elastic_J = 100.0};
  EnergyRange range;
  range.book(start, start, false);
  EXPECT_EQ(range.held_J, 3.0);
  range.book(start, {.kinetic_J = 4.0, .elastic_J = 94.0}, false);
  EXPECT_EQ(range.held_J, 10.0);
  EXPECT_EQ(range.released_J, 6.0);
  EXPECT_EQ(range.given_J(), 9.0);
}

TEST(EnergyRange, KeepsTheLargestOfBothSigns) {
  const EnergyBook start;
  EnergyRange range;
  range.book(start, {.interface_work_J = 2.0, .numerical_loss_J = 1.5}, false);
  range.book(start, {.interface_work_J = 0.0, .numerical_loss_J = 0.25}, false);
  range.book(start, start, false);
  EXPECT_EQ(range.made_J, 0.5);
  EXPECT_EQ(range.lost_J, 0.25);
}

// A line between the sides stores what their interface works differ by.
TEST(EnergyRange, PassesOverWhatALineStores) {
  EnergyRange range;
  range.book({}, {.interface_work_J = 2.0}, true);
  EXPECT_EQ(range.made_J, 0.0);
}

}  // namespace
}  // namespace tandem::orchestrator
