// Micro steps on either side: waveform iteration.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

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

// What one side gives the other gets, micro step by micro step: round-off of 1.68 kg m/s over 40
// steps.
TEST(MultiRate, MicroStepsKeepLinearMomentum) {
  CoupledPair pair(
      "two_masses/scenario.yaml",
      {{"run.duration_s", "0.04"}, {"mbs.micro_step_s", "0.0005"}, {"fem.micro_step_s", "0.0002"}});
  std::optional<Eigen::Vector3d> start;
  double drift = 0.0;
  const RunReport report = pair.run(Mode::Inproc, [&](const Sample&) {
    if (!start) start = pair.linear_momentum();
    drift = std::max(drift, (pair.linear_momentum() - *start).norm());
  });
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_LT(drift, 40 * 64 * 2.2e-16 * 1.68);
}

}  // namespace
}  // namespace tandem::coupled_test
