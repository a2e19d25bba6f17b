// Micro steps on either side: waveform iteration.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <utility>

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
// steps. With Jacobians of every step the residual ends at round-off, too, not just below its
// limit.
TEST(MultiRate, MicroStepsKeepLinearMomentum) {
  CoupledPair pair("two_masses/scenario.yaml", {{"run.duration_s", "0.04"},
                                                {"mbs.micro_step_s", "0.0005"},
                                                {"fem.micro_step_s", "0.0002"},
                                                {"coupling.jacobian.fem_refresh", "every_step"}});
  std::optional<Eigen::Vector3d> start;
  double drift = 0.0;
  const RunReport report = pair.run(Mode::Inproc, [&](const Sample&) {
    if (!start) start = pair.linear_momentum();
    drift = std::max(drift, (pair.linear_momentum() - *start).norm());
  });
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_LT(drift, 40 * 64 * 2.2e-16 * 1.68);
}

// The derivative through micro steps, which is what costs, is taken once and then learned, in the
// axes of the ports: on the turning lug the same macro steps (1e-9 as above) for some half more
// evaluations, which the flexible side makes in a tenth of the time.
TEST(MultiRate, ALearnedJacobianSolvesTheSameMacroSteps) {
  const auto lug = [](const char* refresh) {
    CoupledPair pair("lug/scenario.yaml", {{"run.duration_s", "0.06"},
                                           {"fem.micro_step_s", "0.00025"},
                                           {"fem.solver.kind", "pcg"},
                                           {"coupling.jacobian.fem_refresh", refresh}});
    std::vector<Sample> samples;
    const RunReport report =
        pair.run(Mode::Inproc, [&](const Sample& sample) { samples.push_back(sample); });
    EXPECT_EQ(report.status, RunStatus::Done) << report.message;
    return std::pair(samples, report);
  };
  const auto [exact, exact_report] = lug("every_step");
  const auto [learned, learned_report] = lug("automatic");
  ASSERT_EQ(exact.size(), learned.size());
  EXPECT_LT(largest_relative_difference(exact, learned).motions, 1e-9);
  EXPECT_LT(static_cast<double>(learned_report.iterations_total),
            1.5 * static_cast<double>(exact_report.iterations_total));
}

}  // namespace
}  // namespace tandem::coupled_test
