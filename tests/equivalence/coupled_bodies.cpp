// Several flexible bodies: every scheme against the monolithic step, whatever their number and
// kind.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/chain_of_links.h"
#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

const std::string kTwoBodies = "../tests/data/coupled/systems/two_bodies.yaml";
const std::string kThreeKinds = "../tests/data/coupled/systems/three_kinds.yaml";

struct BodiesRun {
  RunReport report;
  std::vector<Sample> samples;
};

BodiesRun run_bodies(const std::string& scenario, Mode mode,
                     const CoupledPair::Overrides& overrides) {
  CoupledPair pair(scenario, overrides);
  BodiesRun made;
  made.report = pair.run(mode, [&](const Sample& sample) { made.samples.push_back(sample); });
  EXPECT_EQ(made.report.status, RunStatus::Done) << made.report.message;
  return made;
}

CoupledPair::Overrides joined(CoupledPair::Overrides a, const CoupledPair::Overrides& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Every step stops at 1e-12 of the largest wrench, with interface_jacobian at 1e-11, or at
/// round-off; 1e-9 is the project's bound for what some hundred steps make of it. Relative to the
/// quantities of any port: the origins of those on hinges of the world do not move.
constexpr double kBodiesAgree = 1e-9;

void expect_monolithic(const std::string& scenario, const CoupledPair::Overrides& of_both,
                       const std::vector<CoupledPair::Overrides>& schemes, double agreement) {
  const BodiesRun monolithic = run_bodies(scenario, Mode::Monolithic, of_both);
  for (const CoupledPair::Overrides& scheme : schemes) {
    const BodiesRun other = run_bodies(scenario, Mode::Inproc, joined(of_both, scheme));
    ASSERT_EQ(other.samples.size(), monolithic.samples.size());
    const RelativeDifference difference =
        largest_relative_difference(monolithic.samples, other.samples, Scale::AnyPort);
    EXPECT_LT(difference.motions, agreement) << scheme.back().value;
    EXPECT_LT(difference.wrenches, agreement) << scheme.back().value;
  }
}

class ChainOfLinks : public testing::TestWithParam<int> {};

TEST_P(ChainOfLinks, EqualsTheMonolithicStepWhateverItsNumber) {
  const test::TemporaryFolder folder{"tandem_chain"};
  const std::string scenario = test::chain_of(GetParam(), folder).string();
  expect_monolithic(scenario, {{"run.duration_s", "0.01"}},
                    {{{"coupling.scheme", "interface_jacobian"}}}, kBodiesAgree);
}

INSTANTIATE_TEST_SUITE_P(Links, ChainOfLinks, testing::Values(1, 2, 4, 8, 16));

// Blocks that learn, each from its own body's secants: within the accuracy that is asked for.
TEST(SeveralBodies, EqualTheMonolithicStepToTheAccuracyThatIsAskedFor) {
  const test::TemporaryFolder folder{"tandem_chain"};
  const std::string scenario = test::chain_of(4, folder).string();
  const BodiesRun monolithic = run_bodies(scenario, Mode::Monolithic, {{"run.duration_s", "0.1"}});
  for (const char* accuracy : {"1e-4", "1e-6"}) {
    const BodiesRun newton =
        run_bodies(scenario, Mode::Inproc, {{"run.duration_s", "0.1"}, {"run.accuracy", accuracy}});
    const RelativeDifference difference =
        largest_relative_difference(monolithic.samples, newton.samples, Scale::AnyPort);
    EXPECT_LT(difference.motions, std::stod(accuracy));
    EXPECT_LT(difference.wrenches, 10.0 * std::stod(accuracy));
  }
}

const CoupledPair::Overrides kImplicit = {{"coupling.scheme", "implicit"},
                                          {"coupling.max_iterations", "100"}};

std::vector<CoupledPair::Overrides> converging_schemes() {
  return {
      {{"coupling.scheme", "interface_jacobian"}},
      joined(kImplicit, {{"coupling.relaxation", "aitken"}}),
      joined(kImplicit, {{"coupling.relaxation", "anderson"}}),
      joined(kImplicit, {{"coupling.relaxation", "iqn_ils"}}),
      joined(kImplicit, {{"coupling.iteration", "parallel"}, {"coupling.relaxation", "iqn_imvj"}})};
}

TEST(SeveralBodies, EqualTheMonolithicStepInEverySchemeThatConverges) {
  expect_monolithic(kTwoBodies, {}, converging_schemes(), kBodiesAgree);
}

TEST(SeveralBodies, OfThreeKindsEqualTheMonolithicStep) {
  expect_monolithic(kThreeKinds, {}, converging_schemes(), kBodiesAgree);
}

/// Largest distance of a port's positions from the monolithic run's (m).
double distance_m(const CoupledPair::Overrides& scheme, double H_s) {
  const CoupledPair::Overrides steps = {{"run.macro_step_s", text_of(H_s)}};
  const BodiesRun monolithic = run_bodies(kTwoBodies, Mode::Monolithic, steps);
  const BodiesRun other = run_bodies(kTwoBodies, Mode::Inproc, joined(steps, scheme));
  double largest = 0.0;
  for (std::size_t n = 0; n < other.samples.size(); ++n) {
    for (std::size_t p = 0; p < other.samples[n].motions.size(); ++p) {
      largest = std::max(
          largest,
          (other.samples[n].motions[p].p_WP - monolithic.samples[n].motions[p].p_WP).norm());
    }
  }
  return largest;
}

// With hold prediction a wrench, or a motion, of one step ago is an error of order H. A line of the
// stiffness k adds the compliance 1/k and the mass k H²: with k in proportion to 1/H both are of
// order H.
TEST(SeveralBodies, ApproachTheMonolithicSolutionWithOrderOneInSchemesThatDoNotIterate) {
  for (const std::string scheme : {"explicit_serial", "explicit_parallel", "tlm"}) {
    double coarser = 0.0;
    for (int halving = 0; halving <= 3; ++halving) {
      const double H_s = 1.6e-4 / (1 << halving);
      CoupledPair::Overrides overrides = {{"coupling.scheme", scheme}};
      if (scheme == "tlm") {
        overrides.push_back({"coupling.tlm.stiffness_N_per_m", text_of(100.0 / H_s)});
      } else {
        overrides.push_back({"coupling.prediction", "hold"});
      }
      const double error = distance_m(overrides, H_s);
      if (halving > 0) {
        EXPECT_NEAR(std::log2(coarser / error), 1.0, 0.15) << scheme << ", " << H_s << " s";
      }
      coarser = error;
    }
  }
}

}  // namespace
}  // namespace tandem::coupled_test
