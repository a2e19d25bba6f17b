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

Momentum angular_momentum(Mode mode, double h_s, CoupledPair::Overrides overrides) {
  overrides.push_back({"run.macro_step_s", text_of(h_s)});
  CoupledPair pair("two_masses/scenario.yaml", overrides);
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

constexpr double kEpsilon = 2.2e-16;
constexpr double kAngularMomentum = 1.07;  // kg m²/s

/// Bodies without gyroscopic torque, which ODE integrates in its own way. A tumble beside the spin.
CoupledPair::Overrides balls() {
  CoupledPair::Overrides overrides{{"run.duration_s", "0.5"},
                                   {"fem.initial_velocity.angular_rad_per_s", "[2, 1, 3]"}};
  for (const char* body : {"left", "right"}) {
    const std::string path = std::string("mbs.bodies.") + body;
    overrides.push_back({path + ".inertia_kg_m2", "[0.008, 0.008, 0.008]"});
    overrides.push_back({path + ".angular_velocity_rad_per_s", "[2, 1, 3]"});
  }
  return overrides;
}

// Torques close the angular momentum in every step, whatever its length: what is left is what the
// scheme leaves of the wrench, 1e-11 of 160 N and its moments, over at most 0.5 s.
TEST(FreePair, AngularMomentumIsKeptToRoundOff) {
  for (double h_s : {4e-3, 1e-3, 2.5e-4}) {
    for (Mode mode : {Mode::Monolithic, Mode::Inproc}) {
      EXPECT_LT(angular_momentum(mode, h_s, balls()).drift, 1e-11 * 160.0 * 0.5) << h_s;
    }
  }
}

// With unlike principal moments ODE's error of the gyroscopic torque comes in, of order 1; here
// bodies that tip by 1e-6 rad/s. What the interface adds is the difference between the scheme and
// the monolithic step: round-off.
TEST(FreePair, TheInterfaceAddsNothingToTheAngularMomentum) {
  for (int halving = 0; halving <= 4; ++halving) {
    const double h_s = 2.5e-4 / (1 << halving);
    const CoupledPair::Overrides overrides{{"run.duration_s", "0.02"}};
    const Momentum monolithic = angular_momentum(Mode::Monolithic, h_s, overrides);
    const Momentum newton = angular_momentum(Mode::Inproc, h_s, overrides);
    EXPECT_LT((newton.end - monolithic.end).norm(), 64 * kEpsilon * kAngularMomentum);
    EXPECT_LT(monolithic.drift, 1e-9 * kAngularMomentum);
  }
}

}  // namespace
}  // namespace tandem::coupled_test
