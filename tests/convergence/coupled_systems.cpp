// Order in H of port motions, positions, attitudes and both velocities, on small systems that
// differ in joints, springs, dampers, attachments, number of ports and of flexible bodies, against
// the RK4 trajectory of each uncut system (tests/data/coupled/README.md).
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/truth_case.h"

namespace tandem::coupled_test {
namespace {

const std::string kFolder = "tests/data/coupled/systems/";

/// Root sum of squares over all samples and ports; attitudes in rad.
struct MotionError {
  double p = 0.0, q = 0.0, v = 0.0, w = 0.0;
};

Motion motion_of(const std::vector<double>& row, std::size_t at) {
  const auto vector = [&](std::size_t k) {
    return Eigen::Vector3d(row[at + k], row[at + k + 1], row[at + k + 2]);
  };
  return {.p_WP = vector(0),
          .q_WP = Eigen::Quaterniond(row[at + 3], row[at + 4], row[at + 5], row[at + 6]),
          .v_WP = vector(7),
          .w_WP = vector(10)};
}

/// A reference trajectory, and the scenario that it belongs to.
struct System {
  const char* reference;
  const char* scenario;
  CoupledPair::Overrides overrides = {};
};

MotionError error_of(const System& system, CoupledPair::Overrides overrides, double H_s) {
  const Trajectory reference = read_trajectory(std::filesystem::path(TANDEM_SOURCE_DIR) /
                                               (kFolder + system.reference + ".csv"));
  overrides.push_back({"run.macro_step_s", text_of(H_s)});
  overrides.insert(overrides.end(), system.overrides.begin(), system.overrides.end());
  CoupledPair pair("../" + kFolder + system.scenario + ".yaml", overrides);
  MotionError square;
  std::size_t row = 0;
  const RunReport report = pair.run(orchestrator::Mode::Inproc, [&](const Sample& sample) {
    if (row == reference.rows.size()) return;
    if (std::abs(sample.t_s - reference.rows[row][0]) > 1e-9) return;
    for (std::size_t p = 0; p < sample.motions.size(); ++p) {
      const Motion expected = motion_of(reference.rows[row], 1 + 13 * p);
      const Eigen::VectorXd gap = difference({expected}, {sample.motions[p]});
      square.p += gap.segment<3>(0).squaredNorm();
      square.q += gap.segment<3>(3).squaredNorm();
      square.v += gap.segment<3>(6).squaredNorm();
      square.w += gap.segment<3>(9).squaredNorm();
    }
    ++row;
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_EQ(row, reference.rows.size());
  return {std::sqrt(square.p), std::sqrt(square.q), std::sqrt(square.v), std::sqrt(square.w)};
}

/// A key of every flexible body of a system; several are named in its list.
CoupledPair::Overrides of_all_bodies(const System& system,
                                     const CoupledPair::Overrides& of_a_body) {
  const CoupledPair pair("../" + kFolder + system.scenario + ".yaml", {});
  CoupledPair::Overrides all;
  for (const scenario::FlexibleBody& body : pair.model().bodies) {
    const std::string fem = body.name.empty() ? "fem." : "fem." + body.name + ".";
    for (const scenario::Override& own : of_a_body) all.push_back({fem + own.path, own.value});
  }
  return all;
}

/// Two-sided over four halvings.
void expect_order(int order, const System& system, const CoupledPair::Overrides& overrides,
                  double longest_step_s) {
  MotionError coarser;
  for (int halving = 0; halving <= 4; ++halving) {
    const double H_s = longest_step_s / (1 << halving);
    const MotionError error = error_of(system, overrides, H_s);
    if (halving > 0) {
      EXPECT_NEAR(std::log2(coarser.p / error.p), order, 0.15) << "p, " << H_s << " s " << error.p;
      EXPECT_NEAR(std::log2(coarser.q / error.q), order, 0.15) << "q, " << H_s << " s " << error.q;
      EXPECT_NEAR(std::log2(coarser.v / error.v), order, 0.15) << "v, " << H_s << " s " << error.v;
      EXPECT_NEAR(std::log2(coarser.w / error.w), order, 0.15) << "w, " << H_s << " s " << error.w;
    }
    coarser = error;
  }
}

class CoupledSystem : public testing::TestWithParam<System> {};

TEST_P(CoupledSystem, HasOrderOneWithTheDefaultIntegrators) {
  expect_order(1, GetParam(), {}, 1.6e-4);
}

// Without cfm: it yields to joint forces of 100 N by 1e-8 m/s, which is of order 0.
TEST_P(CoupledSystem, HasOrderTwoWithTheSecondOrderPair) {
  CoupledPair::Overrides overrides =
      of_all_bodies(GetParam(), {{"integrator.kind", "hht"}, {"integrator.hht_alpha", "0"}});
  overrides.insert(overrides.end(), {{"mbs.integrator", "verlet"}, {"mbs.cfm", "0"}});
  expect_order(2, GetParam(), overrides, 1.6e-4);
}

const System kSystems[] = {
    {"ball_chain", "ball_chain"},
    {"three_ports", "three_ports"},
    {"both_ends", "both_ends"},
    {"rotor", "rotor"},
    {"loose_ports", "loose_ports"},
    {"two_bodies", "two_bodies"},
    {"junctions", "junctions"},
    {"two_bodies_damped", "two_bodies", {{"fem.strut.damping.beta_s", "0.004"}}}};

INSTANTIATE_TEST_SUITE_P(Systems, CoupledSystem, testing::ValuesIn(kSystems),
                         [](const auto& test) { return std::string(test.param.reference); });

}  // namespace
}  // namespace tandem::coupled_test
