// Steps that are long for the motion: the iterations find the solution that goes on from the past,
// not one that is some turns away.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

struct CoarseRun {
  RunReport report;
  std::vector<Sample> samples;
  double largest_turn_rad = 0.0;  ///< of a port in a step
};

CoarseRun slider_crank(Mode mode, double H_s, const std::string& refresh) {
  // About one turn of the crank.
  const double duration_s = H_s * static_cast<int>(0.64 / H_s);
  CoupledPair pair("slider_crank/scenario.yaml", {{"run.accuracy", "1e-6"},
                                                  {"run.macro_step_s", text_of(H_s)},
                                                  {"run.duration_s", text_of(duration_s)},
                                                  {"coupling.jacobian.fem_refresh", refresh}});
  CoarseRun made;
  made.report = pair.run(mode, [&](const Sample& sample) {
    for (const Motion& motion : sample.motions) {
      made.largest_turn_rad = std::max(made.largest_turn_rad, H_s * motion.w_WP.norm());
    }
    made.samples.push_back(sample);
  });
  return made;
}

class CoarseSteps : public testing::TestWithParam<int> {};

// The crank turns by 0.06 to 0.1 rad in a step; with a Jacobian that is learned from step to step.
TEST_P(CoarseSteps, FollowTheMonolithicSolution) {
  const double H_s = 1e-3 * GetParam();
  const CoarseRun monolithic = slider_crank(Mode::Monolithic, H_s, "automatic");
  ASSERT_EQ(monolithic.report.status, RunStatus::Done) << monolithic.report.message;
  for (const char* refresh : {"broyden", "every_step"}) {
    const CoarseRun run = slider_crank(Mode::Inproc, H_s, refresh);
    EXPECT_EQ(run.report.status, RunStatus::Done) << refresh << ": " << run.report.message;
    EXPECT_LT(run.largest_turn_rad, 0.5) << refresh;
    ASSERT_EQ(run.samples.size(), monolithic.samples.size()) << refresh;
    const RelativeDifference difference =
        largest_relative_difference(monolithic.samples, run.samples, Scale::AnyPort);
    // 1e-6 of the wrench at each of a hundred steps.
    EXPECT_LT(difference.motions, 1e-4) << refresh;
  }
}

INSTANTIATE_TEST_SUITE_P(Milliseconds, CoarseSteps, testing::Values(6, 7, 8, 9, 10));

}  // namespace
}  // namespace tandem::coupled_test
