#include <gtest/gtest.h>

#include "fem_process/keys/fem_keys.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/scenario_file.h"
#include "tests/support/fem_box.h"

namespace tandem::fem {
namespace {

const std::string kSteel = "  material: {young_Pa: 5.0e6, poisson: 0.3, density_kg_per_m3: 1000}\n";

Params read(const std::string& fem, const std::string& micro = "",
            const std::string& material = kSteel,
            const std::string& mesh = "file: bar.msh, length_scale_m: 0.001") {
  const std::string text =
      "run: {duration_s: 1.0, macro_step_s: 0.002}\n"
      "ports:\n  - {name: hub, body: hub, node_set: left, position_m: [1, 2, 3]}\n"
      "fem:\n  mesh: {" +
      mesh + "}\n" + material + micro + fem;
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
  EXPECT_EQ(read_back.threads, expected.threads);
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

TEST(FemKeys, FixedAndWatchTakeAnyNameOfAMesh) {
  const Params p = read("  fixed: [\"Set-1\", Internal-1_slave]\n  watch: [\"PART 1.top\"]\n");
  ASSERT_EQ(p.fixed.size(), 2U);
  EXPECT_EQ(p.fixed[0].name, "Set-1");
  EXPECT_EQ(p.fixed[1].name, "Internal-1_slave");
  ASSERT_EQ(p.watch.size(), 1U);
  EXPECT_EQ(p.watch[0].name, "PART 1.top");
  EXPECT_THROW(read("  fixed: [\"\"]\n"), Error);
}

TEST(FemKeys, EveryKeyArrives) {
  const Params p = read(
      "  mass: lumped\n  damping: {alpha_per_s: 1, beta_s: 0.002}\n"
      "  integrator: {kind: hht, hht_alpha: -0.2}\n"
      "  solver: {kind: pcg, tolerance: 1.0e-8, max_iterations: 77}\n"
      "  threads: 2\n  micro_step_s: 0.001\n  gravity_m_per_s2: [0, 0, -9.81]\n  fixed: [right]\n"
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
  EXPECT_EQ(p.threads, 2);
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

const std::string kPly =
    "kind: orthotropic, young_123_Pa: [1.4e11, 1.0e10, 0.9e10], poisson_12_13_23: [0.3, 0.28, "
    "0.45], shear_12_13_23_Pa: [5.0e9, 4.5e9, 3.5e9], density_kg_per_m3: 1600";

TEST(FemKeys, MaterialsAndOrderArrive) {
  const Params p = read("", "",
                        "  materials:\n    - {set: skin, " + kPly +
                            ", axis_1: [0, 2, 0], axis_2: [3, 1, 0]}\n"
                            "    - {set: core, young_Pa: 1.0e8, poisson: 0.2, "
                            "density_kg_per_m3: 100}\n",
                        "file: bar.msh, order: 2");
  EXPECT_EQ(p.mesh.order, 2);
  ASSERT_EQ(p.materials.size(), 2U);
  EXPECT_EQ(p.materials[0].set.name, "skin");
  EXPECT_GT(p.materials[0].set.place.line, 0);
  const Orthotropic o = p.materials[0].material.orthotropic.value();
  EXPECT_EQ(o.young_Pa, Eigen::Vector3d(1.4e11, 1.0e10, 0.9e10));
  EXPECT_EQ(o.poisson, Eigen::Vector3d(0.3, 0.28, 0.45));
  EXPECT_EQ(o.shear_Pa, Eigen::Vector3d(5e9, 4.5e9, 3.5e9));
  Eigen::Matrix3d axes;  // 1 along y, 2 along x, 3 along −z
  axes << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  EXPECT_EQ(o.axes, axes);
  EXPECT_EQ(p.materials[0].material.density_kg_per_m3, 1600.0);
  EXPECT_FALSE(p.materials[1].material.orthotropic.has_value());
  EXPECT_EQ(p.materials[1].material.young_Pa, 1e8);
  EXPECT_EQ(read("").mesh.order, 0);
}

// A quarter turn about z takes the file's x axis to y.
TEST(FemKeys, MaterialAxesTurnWithTheMesh) {
  const Params p =
      read("", "", "  material: {" + kPly + "}\n",
           "file: bar.msh, orientation_wxyz: [0.7071067811865476, 0, 0, 0.7071067811865476]");
  Eigen::Matrix3d axes;
  axes << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_LT((p.material.orthotropic.value().axes - axes).norm(), 1e-15);
}

std::string refusal(const std::string& material) {
  try {
    read("", "", material);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(FemKeys, MaterialDefectsAreSaidAtTheirPlace) {
  const auto expect = [](const std::string& material, const std::string& part) {
    const std::string found = refusal(material);
    EXPECT_NE(found.find("keys.yaml:"), std::string::npos) << found;
    EXPECT_NE(found.find(part), std::string::npos) << found;
  };
  expect("", "neither material nor materials");
  expect(kSteel + "  materials:\n    - {set: a, young_Pa: 1, poisson: 0, density_kg_per_m3: 1}\n",
         "both material and materials");
  expect("  material: {" + kPly + ", axis_2: [-2, 0, 0]}\n", "parallel to axis_1");
  std::string swapped = kPly;
  swapped.replace(swapped.find("[1.4e11, 1.0e10"), 15, "[1.0e10, 1.4e11");
  expect("  material: {" + swapped + "}\n", "nu_12 = 0.3 of an orthotropic material must be below");
  expect("  material: {" + kPly + ", young_Pa: 1.0}\n", "young_Pa");
}

}  // namespace
}  // namespace tandem::fem
