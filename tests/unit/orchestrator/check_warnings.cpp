// What `tandem check` warns of, each once where it appears and once where it does not.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "fem_process/body/flexible_side.h"
#include "fem_process/sides/make_model.h"
#include "mbs_process/make_side.h"
#include "orchestrator/warnings/body_warnings.h"
#include "orchestrator/warnings/set_warnings.h"
#include "orchestrator/warnings/stability_warnings.h"
#include "orchestrator/warnings/warnings.h"

namespace tandem::orchestrator {
namespace {

using Overrides = std::vector<scenario::Override>;

std::vector<Finding> findings_of(const std::string& example, const Overrides& overrides) {
  const Model model = load_model(
      std::string(TANDEM_SOURCE_DIR) + "/examples/" + example + "/scenario.yaml", overrides);
  const auto rigid = mbs::make_side(model.scenario.root, {});
  const auto flexible = fem::make_model(model.scenario.root, {});
  const auto* body = dynamic_cast<const fem::FlexibleSide*>(flexible.get());
  return warnings_of(model, rigid->params(), body == nullptr ? nullptr : &body->model(),
                     rigid->initialize(WrenchSet(model.port_names.size())));
}

/// The text of the finding of that name; empty: none.
std::string text_of(const std::string& name, const std::string& example,
                    const Overrides& overrides) {
  for (const Finding& finding : findings_of(example, overrides)) {
    if (finding.name == name) return finding.text;
  }
  return "";
}

void expect_words(const std::string& text, const std::vector<std::string>& words) {
  EXPECT_FALSE(text.empty());
  for (const std::string& word : words) {
    EXPECT_NE(text.find(word), std::string::npos) << "'" << word << "' in: " << text;
  }
}

// A bar of 0.5 × 0.05 × 0.05 m and 1.25 kg whose file would be in millimetres: 500 m, 1.25e9 kg.
TEST(CheckWarnings, SizeOfAMeshInMillimetres) {
  expect_words(text_of("implausible_size", "two_masses", {{"fem.mesh.length_scale_m", "1000"}}),
               {"fem.mesh.length_scale_m: the flexible body", "1.25e+09 kg", "length_scale_m: 1;",
                "0.505 m and 1.25 kg"});
  expect_words(text_of("implausible_size", "two_masses", {{"fem.mesh.length_scale_m", "1e-6"}}),
               {"length_scale_m: 1;"});
  EXPECT_EQ(text_of("implausible_size", "two_masses", {{"fem.mesh.length_scale_m", "10"}}), "");
  EXPECT_EQ(text_of("implausible_size", "two_masses", {}), "");
}

// 15 m long, which may be, with 3e4 m³ of it in steel, which may not.
TEST(CheckWarnings, MassThatNoPartHas) {
  expect_words(
      text_of("implausible_size", "lug",
              {{"fem.mesh.length_scale_m", "0.2"}, {"fem.material.density_kg_per_m3", "7850"}}),
      {"1.318e+06 kg", "length_scale_m: 0.0002"});
}

TEST(CheckWarnings, DensityInAnotherUnit) {
  const auto text_at = [](const std::string& density) {
    return text_of("implausible_density", "two_masses",
                   {{"fem.material.density_kg_per_m3", density}});
  };
  expect_words(text_at("7.85e-9"), {"fem.material.density_kg_per_m3", "In t/mm³", "7850 kg/m³"});
  expect_words(text_at("7.85e-6"), {"In kg/mm³", "7850 kg/m³"});
  expect_words(text_at("7.85"), {"In g/cm³", "7850 kg/m³"});
  expect_words(text_at("9.9"), {"9900 kg/m³"});
  EXPECT_EQ(text_at("10.1"), "");
  EXPECT_EQ(text_at("24900"), "");
  expect_words(text_at("25100"), {"25100 kg/m³ is no density"});
}

TEST(CheckWarnings, DensityOfOneOfSeveralMaterials) {
  expect_words(
      text_of("implausible_density", "sandwich", {{"fem.materials.1.density_kg_per_m3", "6e-11"}}),
      {"density_kg_per_m3"});
  EXPECT_EQ(text_of("implausible_density", "sandwich", {}), "");
}

TEST(CheckWarnings, ModulusInAnotherUnit) {
  const auto text_at = [](const std::string& modulus, const std::string& density) {
    return text_of(
        "implausible_modulus", "two_masses",
        {{"fem.material.young_Pa", modulus}, {"fem.material.density_kg_per_m3", density}});
  };
  expect_words(text_at("210", "7850"), {"0.164 m/s", "210 GPa is 2.1e+11 Pa"});
  expect_words(text_at("210000", "7850"), {"210000 MPa is 2.1e+11 Pa"});
  expect_words(text_at("70000", "2700"), {"70000 MPa is 7e+10 Pa"});
  expect_words(text_at("2.1e14", "7850"), {"as in no solid", "Check modulus"});
  EXPECT_EQ(text_at("2.1e11", "7850"), "");  // steel
  EXPECT_EQ(text_at("1.2e12", "3500"), "");  // diamond
  EXPECT_EQ(text_at("7e6", "2200"), "");     // filled rubber
  EXPECT_EQ(text_at("2e3", "1000"), "");     // jelly
  expect_words(text_at("900", "1000"), {"0.949 m/s"});
  // Of a density in t/mm³ that alone is said.
  EXPECT_EQ(text_at("2.1e11", "7.85e-9"), "");
}

TEST(CheckWarnings, MaterialOfAChainInAnotherUnit) {
  expect_words(
      text_of("implausible_modulus", "belt_drive", {{"fem.ancf.material.young_Pa", "210"}}),
      {"fem.ancf.material: ", "A modulus of 210 GPa is 2.1e+11 Pa"});
  expect_words(text_of("implausible_density", "belt_drive",
                       {{"fem.ancf.material.density_kg_per_m3", "3.6e-9"}}),
               {"fem.ancf.material.density_kg_per_m3", "In t/mm³", "3600 kg/m³"});
  EXPECT_EQ(text_of("implausible_modulus", "belt_drive", {}), "");
  EXPECT_EQ(text_of("implausible_density", "belt_drive", {}), "");
}

// (1 − ν)/((1 + ν)(1 − 2ν)) = 1.346 at ν = 0.3.
TEST(CheckWarnings, PoissonLockingOfAChain) {
  const scenario::Override full{"fem.ancf.integration.kind", "full"};
  expect_words(text_of("poisson_locking", "belt_drive", {full}),
               {"fem.ancf.integration.kind", "1.35 times", "axis_d0"});
  EXPECT_EQ(text_of("poisson_locking", "belt_drive", {}), "");
  EXPECT_EQ(text_of("poisson_locking", "belt_drive", {full, {"fem.ancf.material.poisson", "0.1"}}),
            "");
}

TEST(CheckWarnings, TolerancesCoarserThanTheAccuracy) {
  const auto tolerance = [](const std::string& key, const std::string& value) {
    return text_of("coarse_tolerance", "lug", {{key, value}});
  };
  expect_words(tolerance("coupling.relative_tolerance", "0.5"),
               {"coupling.relative_tolerance: 0.5 leaves more than run.accuracy, 1e-06"});
  expect_words(tolerance("fem.solver", "{kind: pcg, tolerance: 0.1}"),
               {"fem.solver.tolerance: 0.1 leaves more"});
  EXPECT_EQ(tolerance("coupling.relative_tolerance", "1e-7"), "");
  EXPECT_EQ(tolerance("fem.solver", "{kind: pcg, tolerance: 1e-9}"), "");
  EXPECT_EQ(text_of("coarse_tolerance", "lug", {}), "");
}

TEST(CheckWarnings, GravityOnOneSideOnly) {
  const std::string name = "gravity_on_one_side";
  expect_words(text_of(name, "lug", {{"fem.gravity_m_per_s2", "[0, 0, 0]"}}),
               {"Set fem.gravity_m_per_s2: [0, 0, -9.81]"});
  expect_words(text_of(name, "lug", {{"mbs.gravity_m_per_s2", "[0, 0, 0]"}}),
               {"Set mbs.gravity_m_per_s2: [0, 0, -9.81]"});
  expect_words(text_of(name, "rope_crane", {{"fem.gravity_m_per_s2", "[0, 0, 0]"}}), {"Set fem."});
  EXPECT_EQ(text_of(name, "lug", {}), "");
  EXPECT_EQ(text_of(name, "two_masses", {}), "");
  // The rigid bodies carry the mass of a quasi-static body, with its weight.
  EXPECT_EQ(
      text_of(name, "lug",
              {{"fem.gravity_m_per_s2", "[0, 0, 0]"}, {"fem.integrator.kind", "quasi_static"}}),
      "");
}

// The end face of 0.05 × 0.05 m has a diagonal of 0.0707 m: three of it from x = −0.25 m.
TEST(CheckWarnings, PortFarFromItsNodes) {
  const auto text_at = [](const std::string& x) {
    return text_of("far_port", "two_masses", {{"mbs.bodies.left.position_m", "[" + x + ", 0, 0]"}});
  };
  expect_words(text_at("-0.47"), {"port 'left'", "0.22 m from the nearest", "3.11 times"});
  EXPECT_EQ(text_at("-0.45"), "");
  EXPECT_EQ(text_at("-0.28"), "");
}

TEST(CheckWarnings, SecondOrderOnOneSideOnly) {
  const std::string name = "orders_differ";
  const scenario::Override rigid{"mbs.integrator", "verlet"};
  const scenario::Override flexible{"fem.integrator.kind", "hht"};
  expect_words(text_of(name, "two_masses", {rigid}), {"Set fem.integrator.kind"});
  expect_words(text_of(name, "two_masses", {flexible}), {"Set mbs.integrator: verlet"});
  EXPECT_EQ(text_of(name, "two_masses", {rigid, flexible}), "");
  EXPECT_EQ(text_of(name, "two_masses", {}), "");
  EXPECT_EQ(text_of(name, "rope_crane", {}), "");
}

TEST(CheckWarnings, FirstOrderTetrahedraInBending) {
  const std::string name = "coarse_in_bending";
  expect_words(text_of(name, "two_masses", {}),
               {"fem.mesh.order: ", "first-order tetrahedra across the thinnest extent of 0.05 m",
                "Set fem.mesh.order: 2"});
  EXPECT_EQ(text_of(name, "two_masses", {{"fem.mesh.order", "2"}}), "");
  EXPECT_EQ(text_of(name, "lug", {}), "") << "is not slender";
}

TEST(CheckWarnings, SetsOfCornersAloneOnSecondOrderMeshes) {
  const auto findings = [](const std::string& set) {
    fem::Params params;
    params.mesh.file = TANDEM_SOURCE_DIR "/tests/data/fem/corner_nodes.inp";
    params.micro_step = SimTime(1'000'000);
    params.fixed = {{.name = set, .place = {"bar.yaml", 5, 11}}};
    return corner_nodes_only(fem::Model(params));
  };
  ASSERT_EQ(findings("corners").size(), 1U);
  // The four sides of the end and the diagonal between its two triangles.
  expect_words(findings("corners")[0].text,
               {"bar.yaml:5:11: set 'corners'", "corner_nodes.inp:84", "4 corner nodes",
                "none of the 5 mid nodes", "Name a *SURFACE"});
  EXPECT_TRUE(findings("face").empty());
}

// The rotor reaches 100 rad/s.
TEST(CheckWarnings, TurnPerStepOfMotorsAndOfTheStart) {
  const std::string name = "turn_per_step";
  expect_words(text_of(name, "rotor", {{"run.macro_step_s", "0.0025"}}),
               {"joint 'shaft' turns with 100 rad/s", "0.25 rad", "run.macro_step_s to 0.002"});
  EXPECT_EQ(text_of(name, "rotor", {{"run.macro_step_s", "0.002"}}), "");
  expect_words(
      text_of(name, "two_masses", {{"mbs.bodies.left.angular_velocity_rad_per_s", "[0, 0, 210]"}}),
      {"body 'left' at t = 0", "0.21 rad"});
  expect_words(
      text_of(name, "two_masses", {{"fem.initial_velocity.angular_rad_per_s", "[0, 210, 0]"}}),
      {"the flexible body at t = 0"});
  EXPECT_EQ(text_of(name, "two_masses", {}), "");
}

// Newmark with β = 1/6: 1/√(1/4 − 1/6) = 3.46 of ω h.
TEST(CheckWarnings, StabilityBoundOfNewmark) {
  const auto text_at = [](const std::string& beta, const std::string& step_s) {
    return text_of("unstable_newmark", "two_masses",
                   {{"mbs.integrator", "verlet"},
                    {"fem.integrator.kind", "newmark"},
                    {"fem.integrator.newmark_beta", beta},
                    {"run.macro_step_s", step_s}});
  };
  expect_words(text_at("0.0833333333333333", "0.001"),
               {"fem.integrator.newmark_beta", "Set newmark_beta: 0.25", "and it has 0.001 s"});
  EXPECT_EQ(text_at("0.0833333333333333", "0.00001"), "");
  EXPECT_EQ(text_at("0.25", "0.001"), "");
}

TEST(CheckWarnings, StabilityBoundOfVerlet) {
  const auto text_at = [](const std::string& beta, const std::string& step_s) {
    return text_of("unstable_verlet", "two_masses",
                   {{"mbs.integrator", "verlet"},
                    {"mbs.newmark_beta", beta},
                    {"fem.integrator.kind", "hht"},
                    {"run.macro_step_s", step_s}});
  };
  expect_words(text_at("0.0833333333333333", "0.008"),
               {"mbs.newmark_beta", "below 2.45", "Set mbs.newmark_beta: 0.25"});
  EXPECT_EQ(text_at("0.0833333333333333", "0.001"), "");
  EXPECT_EQ(text_at("0.25", "0.008"), "");
}

// Verlet of a mass on a spring with all of it in the force at the end, x⁺ = x + h v + h² ((½ − β) a
// + β a⁺), v⁺ = v + h (a + a⁺)/2, a = −ω² x: the recursion's spectral radius passes 1 at the limit.
TEST(CheckWarnings, LimitOfVerletIsThatOfItsRecursion) {
  for (const double beta : {0.0, 1.0 / 12.0, 1.0 / 6.0}) {
    const auto growth = [beta](double angle) {
      const double w = angle * angle;
      Eigen::Matrix2d left, right;
      left << 1.0 + beta * w, 0.0, 0.5 * w, 1.0;
      right << 1.0 - (0.5 - beta) * w, 1.0, -0.5 * w, 1.0;
      return (left.inverse() * right).eigenvalues().cwiseAbs().maxCoeff();
    };
    const double limit = verlet_limit_rad(beta);
    EXPECT_LT(growth(0.999 * limit), 1.0 + 1e-9) << beta;
    EXPECT_GT(growth(1.001 * limit), 1.01) << beta;
  }
  EXPECT_TRUE(std::isinf(verlet_limit_rad(0.25)));
}

TEST(CheckWarnings, StandAtTheirPlaceInTheFile) {
  const std::string text = text_of("coarse_in_bending", "two_masses", {});
  EXPECT_NE(text.find("two_masses/scenario.yaml:"), std::string::npos) << text;
}

}  // namespace
}  // namespace tandem::orchestrator
