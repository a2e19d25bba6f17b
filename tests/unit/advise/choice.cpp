// The choice of tandem advise among candidates, from numbers that are made up.
#include "orchestrator/advise/choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tandem::orchestrator {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// e(H) = c Hᵖ with an error of 1 mm at 1 ms, and 2 ms of wall time a step.
TrialNumbers of_order(double order) {
  return {.solved = true,
          .step_s = 1e-3,
          .error_m = 1e-3,
          .half_error_m = 1e-3 * std::exp2(-order),
          .wall_per_step_s = 2e-3};
}

const ChoiceLimits kLimits{.wanted_m = 4e-3,
                           .reference_error_m = 1e-6,
                           .longest_s = 0.1,
                           .shortest_s = 1e-5,
                           .run_s = 1.0};

TEST(AdviseChoice, FollowsTheOrderOfTheErrorToTheStepThatIsAskedFor) {
  // 4 mm need 4 ms at order 1 and 2 ms at order 2; 4 ms is 2 ms as a number 1, 2, 5 × 10ⁿ.
  const Prospect first = prospect_of(of_order(1.0), kLimits);
  EXPECT_TRUE(first.known);
  EXPECT_NEAR(first.order, 1.0, 1e-12);
  EXPECT_EQ(first.step_s, 2e-3);
  EXPECT_NEAR(first.wall_per_s, 1.0, 1e-12);  // 2 ms of wall time for 2 ms
  const Prospect second = prospect_of(of_order(2.0), kLimits);
  EXPECT_NEAR(second.order, 2.0, 1e-12);
  EXPECT_EQ(second.step_s, 2e-3);

  // A hundredth of the error: a hundredth of the step at order 1, a tenth at order 2.
  ChoiceLimits fine = kLimits;
  fine.wanted_m = 1e-5;
  EXPECT_EQ(prospect_of(of_order(1.0), fine).step_s, 1e-5);
  EXPECT_EQ(prospect_of(of_order(2.0), fine).step_s, 1e-4);
}

TEST(AdviseChoice, KeepsStepsWithinTheirBounds) {
  ChoiceLimits limits = kLimits;
  limits.wanted_m = 1.0;
  limits.longest_s = 3e-3;  // half the limit of an explicit scheme
  EXPECT_EQ(prospect_of(of_order(1.0), limits).step_s, 2e-3);
  limits = kLimits;
  limits.wanted_m = 1e-9;
  EXPECT_EQ(prospect_of(of_order(1.0), limits).step_s, 1e-5);
}

TEST(AdviseChoice, DoesNotTakeRoundOffOrFailuresForAnOrder) {
  TrialNumbers trial = of_order(1.0);
  trial.solved = false;
  EXPECT_FALSE(prospect_of(trial, kLimits).known);
  trial = of_order(1.0);
  trial.half_error_m = 0.0;  // not measured
  EXPECT_FALSE(prospect_of(trial, kLimits).known);
  ChoiceLimits limits = kLimits;
  limits.reference_error_m = 1e-3;  // the error is within that of the reference
  EXPECT_FALSE(prospect_of(of_order(1.0), limits).known);
}

TEST(AdviseChoice, TakesTheCheapestAndTheScenariosOwnWhereTheTimesDoNotTell) {
  std::vector<Prospect> prospects = {
      {.known = true, .order = 1.0, .step_s = 1e-3, .wall_per_s = 2.0},
      {.known = true, .order = 2.0, .step_s = 5e-3, .wall_per_s = 1.0},
      {.known = true, .order = 1.0, .step_s = 0.0, .wall_per_s = 0.1}};
  EXPECT_EQ(cheapest(prospects, 0), 1U);  // the last one has been given up
  EXPECT_EQ(cheapest(prospects, std::nullopt), 1U);
  prospects[0].wall_per_s = 1.09;
  EXPECT_EQ(cheapest(prospects, 0), 0U);
  EXPECT_EQ(cheapest(prospects, std::nullopt), 1U);
  for (Prospect& prospect : prospects) prospect.step_s = 0.0;
  EXPECT_EQ(cheapest(prospects, 0), std::nullopt);
}

TEST(AdviseChoice, ShortensByWhatSpeaksAgainstAStep) {
  const auto turning = [](double rad) {
    return std::vector<Objection>{{.name = "turn_per_step", .value = rad, .limit = 0.2}};
  };
  // 10 rad a step are 50 times too many; 0.21 rad still ask for half the step.
  EXPECT_EQ(shortened(0.1, turning(10.0), 1.0), 2e-3);
  EXPECT_EQ(shortened(0.1, turning(0.21), 1.0), 0.05);
  // An error that falls with H²: 100 times too large, a tenth of the step.
  EXPECT_EQ(shortened(0.01, {{.name = "accuracy", .value = 0.1, .limit = 1e-3, .power = 2.0}}, 1.0),
            1e-3);
  // The worst of several counts, and one run reaches no further than a fiftieth.
  std::vector<Objection> several = turning(0.4);
  several.push_back({.name = "accuracy", .value = 1.0, .limit = 1e-3, .power = 1.0});
  EXPECT_EQ(shortened(0.1, several, 1.0), 2e-3);
  // A run that was not solved has no number.
  EXPECT_EQ(shortened(0.1, {{.name = "not_solved", .value = kInfinity, .limit = 0.0}}, 1.0), 0.05);
}

TEST(AdviseChoice, TellsWhatShorterStepsDoNotCure) {
  const std::vector<Objection> before = {{.name = "numerical_loss", .value = 0.4, .limit = 0.05}};
  const auto now = [](const std::string& name, double value) {
    return Objection{.name = name, .value = value, .limit = 0.05};
  };
  EXPECT_TRUE(stubborn(now("numerical_loss", 0.39), 5e-4, before, 1e-3));
  EXPECT_FALSE(stubborn(now("numerical_loss", 0.2), 5e-4, before, 1e-3));   // it falls
  EXPECT_FALSE(stubborn(now("numerical_loss", 0.39), 8e-4, before, 1e-3));  // not yet halved
  EXPECT_FALSE(stubborn(now("balance_error", 0.39), 5e-4, before, 1e-3));   // another cause
  const std::vector<Objection> failed = {{.name = "not_solved", .value = kInfinity, .limit = 0.0}};
  EXPECT_FALSE(
      stubborn({.name = "not_solved", .value = kInfinity, .limit = 0.0}, 5e-4, failed, 1e-3));
}

TEST(AdviseChoice, RanksWhatSpeaksAgainstARun) {
  EXPECT_EQ(severity({}), 0);
  EXPECT_EQ(severity({{.name = "accuracy"}}), 1);
  EXPECT_EQ(severity({{.name = "accuracy"}, {.name = "numerical_loss"}}), 2);
  EXPECT_EQ(severity({{.name = "elastic_peak"}}), 2);
  EXPECT_EQ(severity({{.name = "numerical_loss"}, {.name = "not_solved"}}), 3);
}

TEST(AdviseChoice, KeepsTheScenariosSettingsWhereTheyAreAsGoodAndNoDearer) {
  const Standing recommended{.whole = true, .wall_per_s = 1.0, .error = 5e-4, .severity = 0};
  Standing own{.whole = true, .wall_per_s = 0.9, .error = 9e-4, .severity = 0};
  EXPECT_TRUE(own_is_better(own, recommended, 1e-3));
  own.wall_per_s = 1.1;
  EXPECT_FALSE(own_is_better(own, recommended, 1e-3));
  own = {.whole = true, .wall_per_s = 0.5, .error = 2e-3, .severity = 0};
  EXPECT_FALSE(own_is_better(own, recommended, 1e-3));  // less accurate than asked for
  own = {.whole = true, .wall_per_s = 0.5, .error = 5e-4, .severity = 2};
  EXPECT_FALSE(own_is_better(own, recommended, 1e-3));  // its verdict is not clean
  own = {.whole = false, .wall_per_s = 0.5, .error = 5e-4, .severity = 0};
  EXPECT_FALSE(own_is_better(own, recommended, 1e-3));  // it did not come to its end
  // Where the recommendation misses the accuracy, too, the lesser error counts.
  EXPECT_TRUE(own_is_better({.whole = true, .wall_per_s = 0.5, .error = 2e-3, .severity = 1},
                            {.whole = true, .wall_per_s = 1.0, .error = 3e-3, .severity = 1},
                            1e-3));
}

TEST(AdviseChoice, StepsDivideTheRun) {
  EXPECT_EQ(nice_below(0.0049), 0.002);
  EXPECT_EQ(nice_below(0.005), 0.005);
  EXPECT_EQ(nice_step_below(0.0049, 0.93), 2e-3);
  EXPECT_EQ(nice_step_below(0.03, 0.93), 0.01);  // 46.5 steps of 20 ms
  EXPECT_TRUE(divides(1e-3, 0.93));
  EXPECT_FALSE(divides(0.02, 0.93));
  // No such number divides a prime number of nanoseconds: the next one below, all the same.
  EXPECT_EQ(nice_step_below(0.03, 1.000000007), 0.02);
}

}  // namespace
}  // namespace tandem::orchestrator
