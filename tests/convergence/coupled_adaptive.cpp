// Adaptive macro steps against fixed ones: round trips at the same error.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

/// The unit of all steps here, and the step of the reference (s).
constexpr double kUnit_s = 2.5e-4;

/// Port motions over the number of units.
using History = std::map<long, MotionSet>;

struct Work {
  double error_m = 0.0;  ///< largest distance of a port from the reference
  std::int64_t round_trips = 0;
};

RunReport run_slider_crank(CoupledPair::Overrides overrides, History& history) {
  overrides.push_back({"coupling.adaptive.min_step_s", text_of(kUnit_s)});
  CoupledPair pair("slider_crank/scenario.yaml", overrides);
  const RunReport report = pair.run(Mode::Inproc, [&](const Sample& sample) {
    history[std::lround(sample.t_s / kUnit_s)] = sample.motions;
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  return report;
}

Work work_of(const CoupledPair::Overrides& overrides, const History& reference) {
  History history;
  const RunReport report = run_slider_crank(overrides, history);
  Work work{.round_trips = report.iterations_total};
  for (const auto& [unit, motions] : history) {
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const double distance_m = (motions[i].p_WP - reference.at(unit)[i].p_WP).norm();
      work.error_m = std::max(work.error_m, distance_m);
    }
  }
  return work;
}

/// Round trips of fixed steps with this error: linear between the logarithms of two runs.
double round_trips_at(double error_m, const Work& coarse, const Work& fine) {
  const double part = std::log(error_m / coarse.error_m) / std::log(fine.error_m / coarse.error_m);
  EXPECT_GT(part, 0.0);
  EXPECT_LT(part, 1.0);
  const auto a = static_cast<double>(coarse.round_trips);
  const auto b = static_cast<double>(fine.round_trips);
  return a * std::pow(b / a, part);
}

// A bar pulls its body, both at rest and free, from 51.3 ms on, where steps have long grown to
// max_step_s. What the ports' wrenches say and what the body has taken up differ by the lag of one
// step of 1 ms at a force that swings between 0 and some 600 N.
TEST(AdaptiveSteps, ExplicitSchemesKeepTheImpulseOfALoadThatBeginsAtRest) {
  for (const char* scheme : {"explicit_serial", "explicit_parallel"}) {
    for (const char* tolerance : {"1e-3", "1e-6"}) {
      CoupledPair pair("../tests/data/coupled/systems/pulled_bar.yaml",
                       {{"coupling.scheme", scheme}, {"coupling.adaptive.tolerance", tolerance}});
      double given_Ns = 0.0, t_s = 0.0, longest_s = 0.0, largest_N = 0.0;
      Sample last;
      const RunReport report = pair.run(Mode::Inproc, [&](const Sample& sample) {
        if (sample.t_s > 0.0) given_Ns += (sample.t_s - t_s) * sample.wrenches[0].f_P_W.x();
        longest_s = std::max(longest_s, sample.t_s - t_s);
        largest_N = std::max(largest_N, std::abs(sample.wrenches[0].f_P_W.x()));
        t_s = sample.t_s;
        last = sample;
      });
      ASSERT_EQ(report.status, RunStatus::Done) << report.message;
      EXPECT_GT(longest_s, 0.01);
      EXPECT_LT(std::abs(given_Ns - 200.0 * last.motions[0].v_WP.x()), 1e-3 * largest_N)
          << scheme << ", " << tolerance;
    }
  }
}

// The crank starts slowly: its steps may be longer there. All runs iterate to 1e-11 of the
// wrenches, so that the steps alone count.
TEST(AdaptiveSteps, SliderCrankTakesFewerRoundTripsThanTheBestFixedStepWithTheSameError) {
  History reference;
  run_slider_crank({{"run.macro_step_s", text_of(kUnit_s)}}, reference);
  const Work coarse = work_of({{"run.macro_step_s", "0.005"}}, reference);
  const Work middle = work_of({{"run.macro_step_s", "0.0025"}}, reference);
  const Work fine = work_of({{"run.macro_step_s", "0.00125"}}, reference);
  for (const char* tolerance : {"0.002", "0.001", "0.0005"}) {
    const Work work = work_of(
        {{"run.macro_step_s", "0.001"}, {"coupling.adaptive.tolerance", tolerance}}, reference);
    const double fixed = work.error_m > middle.error_m
                             ? round_trips_at(work.error_m, coarse, middle)
                             : round_trips_at(work.error_m, middle, fine);
    EXPECT_GT(fixed, 1.04 * static_cast<double>(work.round_trips)) << tolerance;
  }
}

}  // namespace
}  // namespace tandem::coupled_test
