#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/coupled_pair.h"
#include "tests/support/long_tests.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

// The scale of the momentum: Σ m |v| of the two bodies, 2 × 2 kg × 0.98 m/s. The total is zero.
constexpr double kMomentum = 3.9;

struct Balance {
  double drift = 0.0;             ///< of the linear momentum (kg m/s)
  double body_impulse_gap = 0.0;  ///< m Δv − H f applied, largest of any step and body (N s)
  double pair_impulse_gap = 0.0;  ///< H |f applied − f answered|, largest (N s)
};

/// 2,000 steps of the free pair, or 10,000, every one looked at.
Balance balance_of(Mode mode) {
  const std::string duration_s = test::long_tests() ? "10.0" : "2.0";
  CoupledPair pair("two_masses/scenario.yaml", {{"run.duration_s", duration_s}});
  Balance balance;
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  std::vector<mbs::BodyState> before;
  std::int64_t steps = 0;
  const RunReport report = pair.run(mode, [&](const Sample& sample) {
    const std::vector<mbs::BodyState>& bodies = pair.mbs().state().bodies;
    if (sample.applied.empty()) {
      start = pair.linear_momentum();
      before = bodies;
      return;
    }
    ++steps;
    balance.drift = std::max(balance.drift, (pair.linear_momentum() - start).norm());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const double mass = pair.mbs().params().bodies[i].mass_kg;
      const Eigen::Vector3d impulse = 1e-3 * sample.applied[i].f_P_W;
      balance.body_impulse_gap = std::max(
          balance.body_impulse_gap, (mass * (bodies[i].v_WB - before[i].v_WB) - impulse).norm());
      balance.pair_impulse_gap =
          std::max(balance.pair_impulse_gap, (1e-3 * sample.wrenches[i].f_P_W - impulse).norm());
    }
    before = bodies;
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_EQ(steps, test::long_tests() ? 10000 : 2000);
  return balance;
}

void expect_closed(Mode mode) {
  const Balance balance = balance_of(mode);
  EXPECT_LT(balance.drift, 1e-10 * kMomentum);
  // m Δv and H f are rounded at m v = 2 kg m/s: a few ε of it.
  EXPECT_LT(balance.body_impulse_gap, 16 * 2.2e-16 * 2.0);
  // What the schemes leave: ‖r‖ H = 1e-3 s × coupling.relative_tolerance × 160 N.
  EXPECT_LT(balance.pair_impulse_gap, 1e-3 * 1e-11 * 160.0);
}

TEST(FreePair, MonolithicKeepsLinearMomentumOverThousandsOfSteps) {
  expect_closed(Mode::Monolithic);
}

TEST(FreePair, InterfaceJacobianKeepsLinearMomentumOverThousandsOfSteps) {
  expect_closed(Mode::Inproc);
}

}  // namespace
}  // namespace tandem::coupled_test
