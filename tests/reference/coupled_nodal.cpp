#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <vector>

#include "fem_process/keys/fem_keys.h"
#include "fem_process/reduced/component_modes.h"
#include "fem_process/reduced/highest_frequency.h"
#include "fem_process/sides/flexible_body.h"
#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

using Overrides = CoupledPair::Overrides;
using orchestrator::Mode;

Overrides of_step(double macro_step_s, double duration_s, const std::string& scheme) {
  return {{"run.macro_step_s", text_of(macro_step_s)},
          {"run.duration_s", text_of(duration_s)},
          {"coupling.scheme", scheme}};
}

struct Way {
  RunStatus status = RunStatus::Done;
  std::vector<Eigen::Vector3d> u;  ///< of the monitored node, every macro step (m)
};

Way nodal_way(const Overrides& overrides) {
  CoupledPair pair("bar15/scenario.yaml", overrides);
  Way way;
  way.status = pair.run(Mode::Inproc,
                        [&](const Sample&) {
                          way.u.push_back(pair.fem().mean_motion("monitor").displacement_m);
                        })
                   .status;
  return way;
}

/// The bar of the example with its masses in the flexible side.
fem::Params bar(SimTime step, const fem::IntegratorParams& integrator) {
  const CoupledPair pair("bar15/scenario.yaml", {});
  fem::Params params = fem::read_params(pair.model().scenario.root);
  params.nodal = false;
  params.node_ports.clear();
  params.micro_step = step;
  params.integrator = integrator;
  params.integrator.newton_steps = 30;
  params.integrator.newton_tolerance = 1e-12;
  return params;
}

Way whole_way(SimTime step, int steps, const fem::IntegratorParams& integrator,
              fem::FormulationKind formulation = fem::FormulationKind::Corotational) {
  fem::Params params = bar(step, integrator);
  params.formulation = formulation;
  fem::FlexibleBody body(std::move(params));
  body.initialize({});
  Way way;
  way.u.push_back(body.mean_motion("monitor").displacement_m);
  for (int k = 0; k < steps; ++k) {
    EXPECT_EQ(body.advance({.step = step, .input = {}}).outcome, Outcome::Done);
    way.u.push_back(body.mean_motion("monitor").displacement_m);
  }
  return way;
}

// The multibody side's velocities from forces at the end of the step are backward Euler for all
// nodes: the same equations as the whole bar's, iterated there to 1e-12 of the forces, here to the
// coupling's tolerance of 1e-11 N on nodes of 0.1 kg. In the linear formulation: any other's whole
// bar is carried with its own turning, of which single nodes know nothing.
TEST(CoupledNodal, InterfaceNewtonIsBackwardEulerOfTheWholeBar) {
  Overrides overrides = of_step(5e-3, 0.2, "interface_jacobian");
  overrides.push_back({"fem.formulation", "linear"});
  const Way nodal = nodal_way(overrides);
  ASSERT_EQ(nodal.status, RunStatus::Done);
  const Way whole = whole_way(SimTime(5'000'000), 40, {}, fem::FormulationKind::Linear);
  ASSERT_EQ(nodal.u.size(), whole.u.size());
  for (std::size_t k = 0; k < whole.u.size(); ++k) {
    EXPECT_LT((nodal.u[k] - whole.u[k]).norm(), 1e-9) << k;
  }
  EXPECT_GT(whole.u.back().norm(), 0.01);
}

// Symplectic Euler from rest: its velocities belong to half steps, so the way is half a step late
// or early, order 1. The truth is Newmark's method at 0.1 ms, of order 2: its error is (ω h)²/12 of
// the phase of the 3 Hz bending that carries the motion, 1e-6 of the way, where the finest of the
// three differs by half of 0.2 ms times 2 m/s, 1e-3 of the way.
TEST(CoupledNodal, ExplicitCouplingConvergesToTheWholeBarWithOrderOne) {
  const Way truth = whole_way(SimTime(100'000), 3000, {.kind = fem::IntegratorKind::Newmark});
  std::vector<double> errors;
  for (int every : {8, 4, 2}) {
    const Way nodal = nodal_way(of_step(1e-4 * every, 0.3, "explicit_serial"));
    ASSERT_EQ(nodal.status, RunStatus::Done);
    double error = 0.0;
    // At the times of the coarsest step.
    for (std::size_t k = 0; k <= 375; ++k) {
      const std::size_t at = k * 8 / static_cast<std::size_t>(every);
      error = std::max(error, (nodal.u[at] - truth.u[k * 8]).norm());
    }
    errors.push_back(error);
  }
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 1.0, 0.15);
  EXPECT_NEAR(std::log2(errors[1] / errors[2]), 1.0, 0.15);
}

// With velocity Verlet and the forces at the step's end iterated, the nodes move by Newmark's rule
// of average acceleration: an independent program's rule, mass, step and history. Its equilibrium
// iteration and its table's 7 digits allow for 1e-6.
TEST(CoupledNodal, VerletWithInterfaceNewtonRepeatsAnIndependentProgramsHistory) {
  Overrides overrides = of_step(3.1e-3, 0.93, "interface_jacobian");
  overrides.push_back({"mbs.integrator", "verlet"});
  const Way nodal = nodal_way(overrides);
  ASSERT_EQ(nodal.status, RunStatus::Done);
  std::ifstream csv(std::string(TANDEM_SOURCE_DIR) + "/tests/data/fem/beam15_lumped.csv");
  double sum = 0.0;
  double scale = 0.0;
  int rows = 0;
  for (std::string line; std::getline(csv, line);) {
    if (line.empty() || line[0] == '#' || line[0] == 't') continue;
    std::istringstream cells(line);
    char comma = 0;
    double t = 0.0;
    Eigen::Vector3d u;
    cells >> t >> comma >> u.x() >> comma >> u.y() >> comma >> u.z();
    const auto at = static_cast<std::size_t>(std::llround(t / 3.1e-3));
    sum += (nodal.u.at(at) - u).squaredNorm();
    scale += u.squaredNorm();
    ++rows;
  }
  ASSERT_EQ(rows, 30);
  EXPECT_LT(std::sqrt(sum / scale), 1e-6);
}

// Symplectic Euler on a linear bar (a push of 1/1000, 0.1 mm of way) is stable for H < 2/ω_max,
// two-sided: below it no mode exceeds 2/√(4 − (ω H)²) = 5 times its way, above it the highest mode
// grows 1.49 times each step. With all modes asked for
// the eigenvalues are those of a dense solver; Lanczos' iteration has as many steps as unknowns.
TEST(CoupledNodal, ExplicitCouplingIsStableUpToTwoOverTheHighestFrequency) {
  const fem::Model model(bar(SimTime(1'000'000), {}));
  const auto modes =
      fem::fixed_boundary_modes(model, {.modes = 3 * static_cast<int>(model.free.size())});
  const double limit_s = 2.0 / modes.angular_frequencies.maxCoeff();
  const auto grown = [&](double step_s) {
    const double rounded = 1e-9 * std::round(1e9 * step_s);
    Overrides overrides = of_step(rounded, 600 * rounded, "explicit_serial");
    overrides.push_back(
        {"fem.loads", "[{kind: surface, set: load, force_N: [0.05, 0.025, -0.006]}]"});
    const Way way = nodal_way(overrides);
    double largest = way.status == RunStatus::Done ? 0.0 : 1.0;
    for (const Eigen::Vector3d& u : way.u) largest = std::max(largest, u.norm());
    return largest;
  };
  EXPECT_NEAR(fem::explicit_step_limit_s(model), limit_s, 1e-9 * limit_s);
  EXPECT_LT(grown(0.98 * limit_s), 1e-2);
  EXPECT_GT(grown(1.02 * limit_s), 0.1);
}

TEST(CoupledNodal, ImplicitRelaxationGivesTheSameStepsAsNewton) {
  Overrides overrides = of_step(2e-3, 0.04, "implicit");
  overrides.push_back({"coupling.max_iterations", "200"});
  const Way implicit = nodal_way(overrides);
  ASSERT_EQ(implicit.status, RunStatus::Done);
  const Way newton = nodal_way(of_step(2e-3, 0.04, "interface_jacobian"));
  for (std::size_t k = 0; k < newton.u.size(); ++k) {
    EXPECT_LT((implicit.u[k] - newton.u[k]).norm(), 1e-9);
  }
}

// With C = β K and ζ = β ω/2 the limit falls to 2 (√(1 + ζ²) − ζ)/ω_max: two-sided by a run.
TEST(CoupledNodal, DampingShortensTheExplicitStep) {
  fem::Params params = bar(SimTime(1'000'000), {});
  params.damping.beta_s = 1e-3;
  const double limit_s = fem::explicit_step_limit_s(fem::Model(params));
  const auto status = [&](double step_s) {
    const double rounded = 1e-9 * std::round(1e9 * step_s);
    Overrides overrides = of_step(rounded, 400 * rounded, "explicit_serial");
    overrides.push_back({"fem.damping.beta_s", "1e-3"});
    overrides.push_back(
        {"fem.loads", "[{kind: surface, set: load, force_N: [0.05, 0.025, -0.006]}]"});
    return nodal_way(overrides).status;
  };
  EXPECT_EQ(status(0.98 * limit_s), RunStatus::Done);
  EXPECT_NE(status(1.02 * limit_s), RunStatus::Done);
}

// Bodies and ports stand in the resolved scenario, which gives the same run again.
TEST(CoupledNodal, ResolvedScenarioIsComplete) {
  const CoupledPair pair("bar15/scenario.yaml", {});
  EXPECT_EQ(pair.model().port_names.size(), 12U);
  EXPECT_EQ(pair.mbs().params().bodies.size(), 12U);
  double mass = 0.0;
  for (const auto& body : pair.mbs().params().bodies) mass += body.mass_kg;
  // 6 kg less the quarter masses on the clamped nodes: between a half and all of it.
  EXPECT_GT(mass, 3.0);
  EXPECT_LT(mass, 6.0);
  const auto file = std::filesystem::temp_directory_path() / "tandem_nodal_resolved.yaml";
  std::ofstream(file) << pair.model().scenario.resolved_yaml;
  const orchestrator::Model again = orchestrator::load_model(file, {});
  EXPECT_EQ(again.scenario.hash, pair.model().scenario.hash);
}

TEST(CoupledNodal, RefusesWhatItCannotDo) {
  const auto refused = [](const std::string& key, const std::string& value) {
    try {
      const CoupledPair pair("bar15/scenario.yaml", {{key, value}});
      ADD_FAILURE() << key;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Usage) << key;
      EXPECT_NE(std::string(error.what()).find("coupling: nodal"), std::string::npos)
          << error.what();
    }
  };
  refused("fem.mass", "consistent");
  refused("fem.formulation", "craig_bampton");
  refused("fem.gravity_m_per_s2", "[0, 0, -9.81]");
  refused("fem.integrator.kind", "quasi_static");
  refused("fem.micro_step_s", "0.0005");
  refused("fem.changes", "[{at_s: 0.1, release: fixed}]");
  refused("ports", "[{name: head, body: node_5, node_set: load}]");
  refused("mbs.bodies", "[{name: block, mass_kg: 1, inertia_kg_m2: [1, 1, 1]}]");
}

}  // namespace
}  // namespace tandem::coupled_test
