#include "fem_process/fem_keys.h"

#include <gtest/gtest.h>

#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/scenario_file.h"
#include "tests/support/fem_box.h"

namespace tandem::fem {
namespace {

Params read(const std::string& fem, const std::string& micro = "") {
  const std::string text =
      "run: {duration_s: 1.0, macro_step_s: 0.002}\n"
      "ports:\n  - {name: hub, body: hub, node_set: left, position_m: [1, 2, 3]}\n"
      "fem:\n  mesh: {file: bar.msh, length_scale_m: 0.001}\n"
      "  material: {young_Pa: 5.0e6, poisson: 0.3, density_kg_per_m3: 1000}\n" +
      micro + fem;
  scenario::Section table;
  table.keys = {scenario::run_keys(), scenario::ports_keys(), fem_keys()};
  return read_params(scenario::load(testing::temporary_file("keys.yaml", text), table).root);
}

TEST(FemKeys, DefaultsAreThoseOfTheParameterStructs) {
  const Params read_back = read("");
  const Params expected;
  EXPECT_EQ(read_back.mass, expected.mass);
  EXPECT_EQ(read_back.integrator.kind, expected.integrator.kind);
  EXPECT_EQ(read_back.solver.kind, expected.solver.kind);
  EXPECT_EQ(read_back.damping.alpha_per_s, expected.damping.alpha_per_s);
  EXPECT_EQ(read_back.micro_step, SimTime(2'000'000));  // the macro step
  EXPECT_EQ(read_back.mesh.length_scale_m, 0.001);
  ASSERT_EQ(read_back.ports.size(), 1U);
  EXPECT_EQ(read_back.ports[0].set.name, "left");
  EXPECT_EQ(read_back.ports[0].p_WP.value(), Eigen::Vector3d(1, 2, 3));
  const Params pcg = read("  solver: {kind: pcg}\n  integrator: {kind: hht}\n");
  EXPECT_EQ(pcg.solver.tolerance, expected.solver.tolerance);
  EXPECT_EQ(pcg.solver.max_iterations, expected.solver.max_iterations);
  EXPECT_EQ(pcg.integrator.hht_alpha, expected.integrator.hht_alpha);
}

TEST(FemKeys, EveryKeyArrives) {
  const Params p = read(
      "  mass: lumped\n  damping: {alpha_per_s: 1, beta_s: 0.002}\n"
      "  integrator: {kind: hht, hht_alpha: -0.2}\n"
      "  solver: {kind: pcg, tolerance: 1.0e-8, max_iterations: 77}\n"
      "  micro_step_s: 0.001\n  gravity_m_per_s2: [0, 0, -9.81]\n  fixed: [right]\n"
      "  watch: [solid]\n"
      "  loads:\n    - {kind: nodal, set: right, force_N: [1, 2, 3]}\n"
      "    - {kind: surface, set: right, traction_Pa: [4, 5, 6], law: {kind: harmonic, "
      "amplitude: 2, frequency_Hz: 1}}\n"
      "  initial_velocity: {linear_m_per_s: [1, 0, 0], angular_rad_per_s: [0, 2, 0], about_m: "
      "[0, 0, 3], gradient_per_s: [1, 2, 3, 4, 5, 6, 7, 8, 9]}\n");
  EXPECT_EQ(p.mass, MassKind::Lumped);
  EXPECT_EQ(p.damping.alpha_per_s, 1.0);
  EXPECT_EQ(p.damping.beta_s, 0.002);
  EXPECT_EQ(p.integrator.kind, IntegratorKind::Hht);
  EXPECT_EQ(p.integrator.hht_alpha, -0.2);
  EXPECT_EQ(p.solver.tolerance, 1e-8);
  EXPECT_EQ(p.solver.max_iterations, 77);
  EXPECT_EQ(p.micro_step, SimTime(1'000'000));
  EXPECT_EQ(p.gravity_m_per_s2, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(p.fixed.at(0).name, "right");
  EXPECT_GT(p.fixed.at(0).place.line, 0);
  EXPECT_EQ(p.watch.at(0).name, "solid");
  ASSERT_EQ(p.loads.size(), 2U);
  EXPECT_EQ(p.loads[0].value, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(p.loads[0].law(0.3), 1.0);
  EXPECT_EQ(p.loads[1].kind, Load::Kind::Surface);
  EXPECT_NEAR(p.loads[1].law(0.25), 2.0, 1e-15);
  EXPECT_EQ(p.initial_velocity.angular_rad_per_s, Eigen::Vector3d(0, 2, 0));
  EXPECT_EQ(p.initial_velocity.gradient_per_s(0, 1), 2.0);  // row by row
}

TEST(FemKeys, MicroStepThatDoesNotDivideTheMacroStepIsRefused) {
  EXPECT_THROW(read("  micro_step_s: 0.0015\n"), Error);
}

TEST(FemKeys, LoadWithoutItsValueIsRefused) {
  EXPECT_THROW(read("  loads: [{kind: nodal, set: right}]\n"), Error);
}

}  // namespace
}  // namespace tandem::fem
