// Micro steps on either side: waveform iteration.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

struct Rates {
  int mbs = 1, fem = 1;
};

std::vector<Sample> run(double H_s, Rates rates, const CoupledPair::Overrides& scheme) {
  CoupledPair::Overrides overrides = {{"run.duration_s", "0.04"},
                                      {"run.macro_step_s", text_of(H_s)},
                                      {"mbs.micro_step_s", text_of(H_s / rates.mbs)},
                                      {"fem.micro_step_s", text_of(H_s / rates.fem)}};
  overrides.insert(overrides.end(), scheme.begin(), scheme.end());
  CoupledPair pair("two_masses/scenario.yaml", overrides);
  std::vector<Sample> samples;
  const RunReport report =
      pair.run(Mode::Inproc, [&](const Sample& sample) { samples.push_back(sample); });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  return samples;
}

const CoupledPair::Overrides kNewton = {{"coupling.scheme", "interface_jacobian"}};
const CoupledPair::Overrides kWaveform = {{"coupling.scheme", "implicit"},
                                          {"coupling.relaxation", "iqn_ils"}};

// The converged macro step is one system of equations, whoever solves it: 1e-9 as for equal steps.
TEST(MultiRate, WaveformIterationAndInterfaceJacobianSolveTheSameMacroStep) {
  for (const Rates rates : {Rates{4, 1}, Rates{1, 4}, Rates{2, 5}}) {
    const auto newton = run(1e-3, rates, kNewton);
    const auto waveform = run(1e-3, rates, kWaveform);
    ASSERT_EQ(newton.size(), waveform.size());
    EXPECT_LT(largest_relative_difference(newton, waveform).motions, 1e-9)
        << rates.mbs << " : " << rates.fem;
  }
}

double position_error(const std::vector<Sample>& a, const std::vector<Sample>& b) {
  const Eigen::VectorXd d = difference(a.back().motions, b.back().motions);
  return std::hypot(d.segment<3>(0).norm(), d.segment<3>(12).norm());
}

// Both integrators are of first order in their micro steps and wrenches are interpolated linearly:
// with the ratio kept, the distance from a fine run falls with H for every ratio. The fine run's
// own error is a sixteenth of the finest one's.
TEST(MultiRate, ConvergesToOneAnswerForEveryRatioOfMicroSteps) {
  const auto fine = run(3.90625e-6, {1, 1}, kNewton);
  for (const Rates rates : {Rates{4, 1}, Rates{1, 4}, Rates{2, 2}}) {
    double coarser = 0.0;
    for (int halving = 0; halving <= 2; ++halving) {
      const double error = position_error(fine, run(2.5e-4 / (1 << halving), rates, kWaveform));
      if (halving > 0) {
        EXPECT_NEAR(std::log2(coarser / error), 1.0, 0.2)
            << rates.mbs << " : " << rates.fem << ", halving " << halving;
      }
      coarser = error;
    }
  }
}

}  // namespace
}  // namespace tandem::coupled_test
