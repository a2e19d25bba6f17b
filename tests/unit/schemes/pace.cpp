// Runs that are held to the wall clock, and steps whose number of evaluations is bounded.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>

#include "protocol/contract/cost.h"
#include "tests/support/split_oscillator.h"

namespace tandem {
namespace {

using Case = test::SplitOscillator;

std::int64_t sum_of(const nlohmann::ordered_json& counts) {
  std::int64_t sum = 0;
  for (const auto& [name, count] : counts.items()) sum += count.get<std::int64_t>();
  return sum;
}

TEST(Pace, HoldsTheRunToTheWallClockAndChangesNoBit) {
  Case c{.fem_kg = 0.5, .stiffness = 1e3};
  const RunReport free = run(c);
  ASSERT_EQ(free.status, RunStatus::Done) << free.message;
  EXPECT_FALSE(to_json(free).contains("pace"));
  c.pace = 2.0;
  const double begin_s = now_s();
  const RunReport paced = run(c);
  const double took_s = now_s() - begin_s;
  ASSERT_EQ(paced.status, RunStatus::Done) << paced.message;
  EXPECT_EQ(paced.state_hash, free.state_hash);
  // 0.1 s at twice the wall clock: not before; how much later is the machine's affair.
  EXPECT_GE(took_s, 0.05);
  EXPECT_GT(paced.pace.waited_s, 0.0);
  EXPECT_LT(paced.pace.waited_s, paced.wall_s);
  // Waiting is nobody's work.
  EXPECT_LT(paced.ledger.other_s, paced.wall_s - paced.pace.waited_s);
}

TEST(Pace, CountsEveryStepOnceAndMissesAsLateOnes) {
  const RunReport report = run(Case{.fem_kg = 0.5, .stiffness = 1e3, .pace = 1.0});
  ASSERT_EQ(report.pace.slack_us.size(), 100U);
  const auto late = std::count_if(report.pace.slack_us.begin(), report.pace.slack_us.end(),
                                  [](double slack_us) { return slack_us < 0.0; });
  EXPECT_EQ(report.pace.misses, late);
  const auto json = to_json(report).at("pace");
  EXPECT_EQ(sum_of(json.at("slack_of_step")), 100);
  EXPECT_EQ(sum_of(json.at("missed_by")), late);
  EXPECT_EQ(json.at("misses"), late);
  EXPECT_LE(json.at("slack_us").at("min").get<double>(),
            json.at("slack_us").at("median").get<double>());
  EXPECT_LE(json.at("step_us").at("p99").get<double>(), json.at("step_us").at("max").get<double>());
}

// No machine makes a macro step of a millisecond in a nanosecond.
TEST(Pace, EveryStepOfAHopelessPaceIsAMiss) {
  const RunReport report = run(Case{.fem_kg = 0.5, .stiffness = 1e3, .pace = 1e6});
  EXPECT_EQ(report.status, RunStatus::Done);
  EXPECT_EQ(report.pace.misses, 100);
  EXPECT_EQ(
      std::accumulate(report.pace.missed_by.begin(), report.pace.missed_by.end(), std::int64_t{0}),
      100);
}

/// A step in which the scheme's own time is long and all else as ever.
TEST(Pace, ALateStepIsBookedToThePartThatTookMoreThanItDoes) {
  Pace pace(1e6);
  pace.begin();
  const auto no_rest = [](double) { FAIL() << "nothing is early"; };
  const Ledger usual{.mbs_compute_s = 3e-3, .fem_compute_s = 1e-3, .transit_s = 1e-3};
  for (int n = 1; n <= 10; ++n) pace.end_step(SimTime(n), usual, 5e-3, no_rest);
  Ledger slow = usual;
  slow.transit_s = 2e-3;
  pace.end_step(SimTime(11), slow, 6e-3, no_rest);
  const auto before = pace.report().missed_by;
  EXPECT_EQ(before[2], 1);  // transfer, though mbs takes most
  slow.fem_compute_s = 9e-3;
  pace.end_step(SimTime(12), slow, 15e-3, no_rest);
  EXPECT_EQ(pace.report().missed_by[1], before[1] + 1);
}

// Whatever the pace, what may end the run is looked at many times a second.
TEST(Pace, RestsInShortPieces) {
  Pace pace(1e-6);
  pace.begin();
  int rests = 0;
  const auto rest = [&](double seconds) {
    EXPECT_LE(seconds, 0.05);
    if (++rests == 3) throw std::runtime_error("stopped");
  };
  EXPECT_THROW(pace.end_step(SimTime(1'000'000), {}, 1e-3, rest), std::runtime_error);
  EXPECT_EQ(rests, 3);
}

// A hardening spring: two evaluations leave something, which is booked; what is left grows as the
// bound is lowered.
TEST(Budget, EndsAStepAfterSoManyEvaluationsAndBooksWhatIsLeft) {
  Case c{.mbs_kg = 2.0, .fem_kg = 0.5, .stiffness = 1e4, .hardening = 1e6};
  for (const SchemeKind scheme : {SchemeKind::InterfaceNewton, SchemeKind::Implicit}) {
    c.coupling = {.scheme = scheme};
    c.coupling.relaxation = Relaxation::IqnIls;
    c.coupling.jacobian = {.mbs_refresh = Refresh::Broyden, .fem_refresh = Refresh::Broyden};
    const RunReport whole = run(c);
    ASSERT_EQ(whole.status, RunStatus::Done) << whole.message;
    EXPECT_EQ(whole.steps_out_of_budget, 0);
    ASSERT_GT(whole.iterations_max, 3) << to_string(scheme);
    double left_N = whole.residual_max_N;
    for (const std::int32_t most : {3, 2}) {
      c.coupling.max_evaluations = most;
      const RunReport bound = run(c);
      ASSERT_EQ(bound.status, RunStatus::Done) << to_string(scheme) << most << bound.message;
      EXPECT_EQ(bound.iterations_max, most);
      EXPECT_GT(bound.steps_out_of_budget, 0);
      EXPECT_EQ(bound.not_converged_steps, 0);
      EXPECT_GT(bound.residual_max_N, left_N) << to_string(scheme) << " " << most;
      left_N = bound.residual_max_N;
      EXPECT_EQ(to_json(bound).at("steps_out_of_budget"), bound.steps_out_of_budget);
    }
  }
}

}  // namespace
}  // namespace tandem
