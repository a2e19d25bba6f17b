#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

/// Largest change of the free pair's angular momentum within 20 ms, and its value at the end.
struct Momentum {
  double drift = 0.0;
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
};

Momentum angular_momentum(Mode mode, double h_s) {
  CoupledPair pair("two_masses/scenario.yaml",
                   {{"run.duration_s", "0.02"}, {"run.macro_step_s", text_of(h_s)}});
  Momentum momentum;
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  const RunReport report = pair.run(mode, [&](const Sample& sample) {
    momentum.end = pair.angular_momentum();
    if (sample.applied.empty()) start = momentum.end;
    momentum.drift = std::max(momentum.drift, (momentum.end - start).norm());
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  return momentum;
}

// The error of the angular momentum is the two integrators' own, order 1. What the interface adds
// is the difference between the scheme and the monolithic step: round-off of 1.07 kg m²/s.
TEST(FreePair, AngularMomentumErrorVanishesWithOrderOneAndTheInterfaceAddsNothing) {
  double coarser = 0.0;
  for (int halving = 0; halving <= 4; ++halving) {
    const double h_s = 2.5e-4 / (1 << halving);
    const Momentum monolithic = angular_momentum(Mode::Monolithic, h_s);
    const Momentum newton = angular_momentum(Mode::Inproc, h_s);
    EXPECT_LT((newton.end - monolithic.end).norm(), 64 * 2.2e-16 * 1.07);
    if (halving > 0) {
      EXPECT_NEAR(std::log2(coarser / monolithic.drift), 1.0, 0.15) << "halving " << halving;
    }
    coarser = monolithic.drift;
  }
}

}  // namespace
}  // namespace tandem::coupled_test
