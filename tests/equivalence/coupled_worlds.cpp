// Several multibody worlds, joined by flexible bodies: every scheme against the monolithic step,
// and the same mechanism written as one world.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/coupled_pair.h"
#include "tests/support/two_worlds.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;
using test::Written;

struct WorldsRun {
  RunReport report;
  std::vector<Sample> samples;
};

WorldsRun run_worlds(const std::string& scenario, Mode mode,
                     const CoupledPair::Overrides& overrides) {
  CoupledPair pair(scenario, overrides);
  WorldsRun made;
  made.report = pair.run(mode, [&](const Sample& sample) { made.samples.push_back(sample); });
  EXPECT_EQ(made.report.status, RunStatus::Done) << made.report.message;
  return made;
}

/// The project's bound, as for several flexible bodies in coupled_bodies.cpp.
constexpr double kWorldsAgree = 1e-9;

void expect_agreement(const WorldsRun& a, const WorldsRun& b, double agreement,
                      const std::string& which) {
  ASSERT_EQ(a.samples.size(), b.samples.size()) << which;
  const RelativeDifference difference =
      largest_relative_difference(a.samples, b.samples, Scale::AnyPort);
  EXPECT_LT(difference.motions, agreement) << which;
  EXPECT_LT(difference.wrenches, agreement) << which;
}

class JoinedWorlds : public testing::TestWithParam<int> {
 protected:
  [[nodiscard]] std::string scenario(Written written) const {
    return test::two_worlds(GetParam(), folder_, written).string();
  }
  test::TemporaryFolder folder_{"tandem_worlds"};
};

TEST_P(JoinedWorlds, EqualTheMonolithicStepInEverySchemeThatConverges) {
  const std::string worlds = scenario(Written::AsTwoWorlds);
  const WorldsRun monolithic = run_worlds(worlds, Mode::Monolithic, {});
  const std::vector<CoupledPair::Overrides> schemes = {{{"coupling.scheme", "interface_jacobian"}},
                                                       {{"coupling.scheme", "implicit"},
                                                        {"coupling.max_iterations", "200"},
                                                        {"coupling.relaxation", "iqn_ils"}}};
  for (const CoupledPair::Overrides& scheme : schemes) {
    expect_agreement(monolithic, run_worlds(worlds, Mode::Inproc, scheme), kWorldsAgree,
                     scheme.front().value);
  }
}

/// Two worlds are two islands of one, which ODE steps one by one: the numbers are the same, in
/// whatever order they are summed. Some hundred roundings.
constexpr double kRoundOff = 1e-12;

// Integrators of either order, with micro steps.
TEST_P(JoinedWorlds, EqualTheSameMechanismInOneWorld) {
  const std::vector<std::vector<std::pair<std::string, std::string>>> settings = {
      {}, {{"integrator", "verlet"}}, {{"micro_step_s", "0.0005"}}};
  for (const auto& setting : settings) {
    CoupledPair::Overrides of_two, of_one;
    for (const auto& [key, value] : setting) {
      for (const std::string world : {"near", "far"}) {
        of_two.push_back({"mbs." + world + "." + key, value});
      }
      of_one.push_back({"mbs.all." + key, value});
    }
    for (const Mode mode : {Mode::Monolithic, Mode::Inproc}) {
      const WorldsRun two = run_worlds(scenario(Written::AsTwoWorlds), mode, of_two);
      const WorldsRun one = run_worlds(scenario(Written::AsOneWorld), mode, of_one);
      expect_agreement(one, two, kRoundOff, setting.empty() ? "" : setting.front().first);
      EXPECT_NEAR(two.report.energy_end.sum().total_J(), one.report.energy_end.sum().total_J(),
                  kRoundOff * std::abs(one.report.energy_end.sum().kinetic_J));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Links, JoinedWorlds, testing::Values(1, 2));

// The free pair of examples/two_masses, a world for each mass: the momentum that two processes
// could lose between them is kept by the coupling.
TEST(JoinedWorldsInSpace, KeepLinearMomentum) {
  const std::string of_each =
      "gravity_m_per_s2: [0, 0, 0], bodies: [{mass_kg: 2.0, inertia_kg_m2: [0.004, 0.008, 0.008], "
      "angular_velocity_rad_per_s: [0, 0, 3], ";
  const std::string worlds =
      "[{name: west, " + of_each +
      "name: left, position_m: [-0.28, 0, 0], velocity_m_per_s: [-0.5, -0.84, 0]}]}, {name: "
      "east, " +
      of_each + "name: right, position_m: [0.28, 0, 0], velocity_m_per_s: [0.5, 0.84, 0]}]}]";
  const CoupledPair::Overrides short_run = {{"run.duration_s", "0.2"}};
  CoupledPair pair("two_masses/scenario.yaml", {{"mbs", worlds}, short_run.front()});
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  double drift = 0.0;
  std::vector<Sample> samples;
  const RunReport report = pair.run(Mode::Inproc, [&](const Sample& sample) {
    if (sample.applied.empty()) start = pair.linear_momentum();
    drift = std::max(drift, (pair.linear_momentum() - start).norm());
    samples.push_back(sample);
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_LT(drift, 1e-10 * 3.9) << "Σ m |v| of the two bodies, as in free_pair.cpp (kg m/s)";
  const WorldsRun one = run_worlds("two_masses/scenario.yaml", Mode::Inproc, short_run);
  expect_agreement(one, {.report = report, .samples = samples}, kRoundOff, "one world");
}

}  // namespace
}  // namespace tandem::coupled_test
