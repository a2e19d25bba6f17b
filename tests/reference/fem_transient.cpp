#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "fem_process/sides/flexible_body.h"
#include "tests/support/fem_reference_cases.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

struct Row {
  Eigen::Vector3d svk;    ///< m
  Eigen::Vector3d corot;  ///< m
};

/// Every tenth of 300 steps.
std::vector<Row> read_history(const std::string& name) {
  std::ifstream csv(data_file("transient_reference.csv"));
  std::vector<Row> rows;
  for (std::string line; std::getline(csv, line);) {
    if (!line.starts_with(name + ",")) continue;
    std::stringstream fields(line.substr(name.size()));
    char separator = 0;
    std::array<double, 7> value{};
    for (double& v : value) fields >> separator >> v;
    rows.push_back({{value[1], value[2], value[3]}, {value[4], value[5], value[6]}});
  }
  return rows;
}

struct History {
  std::string mesh;
  FormulationKind formulation;
  SimTime step;
  double load_factor;
  IntegratorParams integrator{.kind = IntegratorKind::Newmark};
};
class FemHistory : public ::testing::TestWithParam<History> {};

// Newmark's average acceleration, which is HHT with α = 0 as well; same mass, same step, both
// iterated to equilibrium in every step. The histories are printed to 7 digits; 300 residuals of
// 1e-8, squared by the last correction, add less.
TEST_P(FemHistory, AgreesWithAnIndependentProgram) {
  const History& history = GetParam();
  ReferenceCase reference = reference_case(history.mesh);
  Params& params = reference.params;
  params.formulation = history.formulation;
  params.loads.front().value *= history.load_factor;
  params.integrator = history.integrator;
  params.integrator.newton_steps = 10;
  params.micro_step = history.step;
  const std::vector<Row> expected = read_history(history.mesh);
  ASSERT_EQ(expected.size(), 30U);
  FlexibleBody body(params);
  body.initialize({});
  double error = 0.0;
  double norm = 0.0;
  for (int step = 1; step <= 300; ++step) {
    const auto result = body.advance({.step = history.step, .input = {}});
    ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
    if (step % 10 != 0) continue;
    const Row& row = expected[static_cast<std::size_t>(step / 10 - 1)];
    const Eigen::Vector3d& u =
        history.formulation == FormulationKind::TotalLagrangian ? row.svk : row.corot;
    error += (mean_displacement(body.model(), reference.monitor, body.state().x) - u).squaredNorm();
    norm += u.squaredNorm();
  }
  EXPECT_LT(std::sqrt(error / norm), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(
    Cases, FemHistory,
    ::testing::Values(
        History{"cantilever_c1", FormulationKind::Corotational, SimTime(4'600'000), 0.4},
        History{"cantilever_c1", FormulationKind::TotalLagrangian, SimTime(4'600'000), 0.4},
        History{"beam15", FormulationKind::Corotational, SimTime(3'100'000), 0.5},
        History{"beam15", FormulationKind::ConsistentCorotational, SimTime(3'100'000), 0.5},
        History{"beam15", FormulationKind::TotalLagrangian, SimTime(3'100'000), 0.5},
        History{"beam15",
                FormulationKind::Corotational,
                SimTime(3'100'000),
                0.5,
                {.kind = IntegratorKind::Hht, .hht_alpha = 0.0}},
        History{"beam15",
                FormulationKind::TotalLagrangian,
                SimTime(3'100'000),
                0.5,
                {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 1.0}}));

}  // namespace
}  // namespace tandem::fem
