// `tandem fem` on beams: scenarios as a user would write them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>

#include "orchestrator/commands/fem_command.h"
#include "orchestrator/scenario/scenario_table.h"
#include "protocol/contract/error.h"
#include "tests/support/ancf_support.h"

namespace tandem::orchestrator {
namespace {

using fem::ancf::testing::number;
using fem::ancf::testing::read_rows;

const char* const kCantilever = R"(name: cantilever
fem:
  model: ancf
  ancf:
    path: {kind: line, length_m: 1}
    chain: {elements: 16, left_support: clamped}
    section: {width_m: 0.02, height_m: 0.02}
    material: {law: svk, young_Pa: 2.0e+8, poisson: 0, density_kg_per_m3: 1000}
    integration: {strain: compatible, points: [5, 3, 3]}
    loads: [{at: 1, force_N: [0, 0, 8]}]
    watch: [{name: tip, at: 1}]
)";

const char* const kPendulum = R"(name: pendulum
run: {duration_s: 0.5, macro_step_s: 0.001}
fem:
  model: ancf
  gravity_m_per_s2: [0, 0, -9.81]
  ancf:
    path: {kind: line, length_m: 1}
    chain: {elements: 8, left_support: hinged}
    section: {width_m: 0.02, height_m: 0.02}
    material: {law: svk, young_Pa: 2.0e+6, poisson: 0.3, density_kg_per_m3: 7200}
    integration: {kind: axis_d0, strain: compatible}
    integrator: {rho_inf: 1}
    watch: [{name: tip, at: 1}]
)";

class AncfCommand : public ::testing::Test {
 protected:
  FemOutcome run(const std::string& yaml, const std::string& analysis) {
    const std::filesystem::path file = folder_ / "scenario.yaml";
    std::ofstream(file) << yaml;
    const scenario::Loaded loaded = scenario::load(file, fem_scenario_table(), {});
    return run_fem(loaded.root, analysis, folder_);
  }
  void SetUp() override {
    folder_ =
        std::filesystem::path(::testing::TempDir()) /
        ("ancf_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(AncfCommand, StaticCantileverIsTheTablesOne) {
  const FemOutcome outcome = run(kCantilever, "static");
  EXPECT_EQ(outcome.exit_code, 0);
  // 8 N is F L²/EI = 3: 16 elements give 0.60139511.
  const auto tip = outcome.results["load_steps"].back()["displacement_m"]["tip"];
  EXPECT_NEAR(tip[2].get<double>(), 0.60139511, 2e-7);
  EXPECT_NEAR(tip[0].get<double>(), -0.25295457, 2e-7);
}

TEST_F(AncfCommand, ModesOfTheCantileverAreThoseOfEulerAndBernoulli) {
  const FemOutcome outcome = run(kCantilever, "modes");
  // f = λ²/(2π L²) √(EI/(ρA)), λ = 1.87510; 16 elements bend 0.1 % too stiffly.
  const double f = 1.8751041 * 1.8751041 / (2.0 * std::numbers::pi) *
                   std::sqrt(2e8 * 0.02 * 0.02 / 12.0 / 1000.0);
  EXPECT_NEAR(outcome.results["frequencies_Hz"][0].get<double>(), f, 2e-3 * f);
}

TEST_F(AncfCommand, ARopeBetweenPortsVibratesAsAString) {
  const FemOutcome outcome = run(R"(name: string
ports:
  - {name: a, body: left}
  - {name: b, body: right}
fem:
  model: ancf
  ancf:
    path: {kind: line, length_m: 2}
    chain: {elements: 16, strain: 0.01}
    section: {width_m: 0.01, height_m: 0.01}
    material: {law: svk, young_Pa: 1.0e+9, poisson: 0, density_kg_per_m3: 1000}
    attachments:
      - {port: a, end: left}
      - {port: b, end: right}
)",
                                 "modes");
  // f = √(T/μ)/(2 L) with both ends held, T = A λ E (λ² − 1)/2 of St. Venant and Kirchhoff's law,
  // μ = ρ A/λ; its bending stiffness adds π² E I/(2 T L²) = 0.1 %.
  const double stretch = 1.01;
  const double tension = 1e-4 * stretch * 1e9 * 0.5 * (stretch * stretch - 1.0);
  const double f = std::sqrt(tension / (1000.0 * 1e-4 / stretch)) / 4.0;
  const double stiff = std::numbers::pi * std::numbers::pi * (1e9 * 1e-8 / 12.0) / (8.0 * tension);
  const auto& found = outcome.results["frequencies_Hz"];
  EXPECT_LT(found[0].get<double>(), 0.01);  // turns about itself
  EXPECT_NEAR(found[1].get<double>(), f * (1.0 + stiff), 2e-3 * f);
  EXPECT_NEAR(found[2].get<double>(), f * (1.0 + stiff), 2e-3 * f);
}

// The bodies are held where they stand: the same as ports that say it themselves.
TEST_F(AncfCommand, PortsOfATransientStandAtTheirBodies) {
  const auto rope = [](const std::string& ports, const std::string& mbs) {
    return "name: rope\nrun: {duration_s: 0.02, macro_step_s: 0.001}\n" + ports + mbs + R"(fem:
  model: ancf
  gravity_m_per_s2: [0, 0, -9.81]
  ancf:
    path: {kind: line, length_m: 2}
    chain: {elements: 8, strain: 0.01}
    section: {width_m: 0.01, height_m: 0.01}
    material: {law: svk, young_Pa: 1.0e+9, poisson: 0, density_kg_per_m3: 1000}
    attachments:
      - {port: a, end: left}
      - {port: b, end: right}
    watch: [{name: end, at: 1}, {name: middle, at: 0.5}]
)";
  };
  const std::string unsaid = "ports: [{name: a, body: left}, {name: b, body: right}]\n";
  const std::string said =
      "ports: [{name: a, body: left, position_m: [0, 0, 0]}, "
      "{name: b, body: right, position_m: [2, 0, 0]}]\n";
  const std::string bodies =
      "mbs:\n  bodies:\n"
      "    - {name: left, mass_kg: 1, inertia_kg_m2: [1, 1, 1], position_m: [0, 0, 0]}\n"
      "    - {name: right, mass_kg: 1, inertia_kg_m2: [1, 1, 1], position_m: [2, 0, 0], "
      "velocity_m_per_s: [1, 0, 0]}\n";
  const FemOutcome from_bodies = run(rope(unsaid, bodies), "transient");
  const auto& history = from_bodies.results["history"]["displacement_m"];
  EXPECT_EQ(history, run(rope(said, ""), "transient").results["history"]["displacement_m"]);
  // Held: it does not follow the body's velocity; between the ends the rope sags.
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(history["end"].back()[k].get<double>(), 0.0, 1e-12);
  EXPECT_LT(history["middle"].back()[2].get<double>(), -1e-4);
  try {
    static_cast<void>(run(rope(unsaid, ""), "transient"));
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("no section mbs whose body 'left'"), std::string::npos)
        << error.what();
  }
}

TEST_F(AncfCommand, ElementSpectrumIsTheReferencesOne) {
  std::string link = kCantilever;
  const auto put = [&](const std::string& from, const std::string& to) {
    link.replace(link.find(from), from.size(), to);
  };
  put("length_m: 1}", "length_m: 0.116321}");
  put("elements: 16, left_support: clamped", "elements: 1");
  put("{width_m: 0.02, height_m: 0.02}", "{width_m: 0.4, height_m: 0.02}");
  put("law: svk, young_Pa: 2.0e+8, poisson: 0, density_kg_per_m3: 1000",
      "law: neo_hookean, neo_hookean_Pa: 1.0e+8, bulk_Pa: 1.0e+9, density_kg_per_m3: 2000");
  link += "  analysis: {modes: 24}\n";
  const FemOutcome outcome = run(link, "modes");
  for (const auto& row : read_rows("element_spectrum.csv")) {
    if (row.at("integration") != "0" || number(row, "mu") != 1e8) continue;
    for (int mode = 1; mode <= 24; ++mode) {
      const double omega =
          2.0 * std::numbers::pi *
          outcome.results["frequencies_Hz"][static_cast<std::size_t>(mode - 1)].get<double>();
      // Six rigid motions, then four digits.
      const double expected = mode <= 6 ? 0.0 : number(row, fmt::format("w{}", mode));
      EXPECT_NEAR(omega, expected, mode <= 6 ? 1.0 : 1e-3 * expected) << mode;
    }
  }
}

TEST_F(AncfCommand, PendulumSwingsAsTheReference) {
  const FemOutcome outcome = run(kPendulum, "transient");
  EXPECT_EQ(outcome.exit_code, 0);
  const auto tip = outcome.results["history"]["displacement_m"]["tip"].back();
  // Integrated with 5 × 3 × 3 points there and 4 × 2 × 2 here.
  EXPECT_NEAR(1.0 + tip[0].get<double>(), -0.14907255, 1e-4);
  EXPECT_NEAR(tip[2].get<double>(), -1.01452512, 1e-4);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "beam.csv"));
}

TEST_F(AncfCommand, FreeRingFallsWithoutStrain) {
  const FemOutcome outcome = run(R"(name: ring
run: {duration_s: 0.1, macro_step_s: 0.001}
output: {vtu_every_steps: 100}
fem:
  model: ancf
  gravity_m_per_s2: [0, 0, -9.81]
  ancf:
    path: {kind: loop, center1_m: [0, 0, 1], center2_m: [0, 0, 1], radius1_m: 0.5, radius2_m: 0.5}
    chain: {elements: 12, stress_free: path}
    section: {width_m: 0.02, height_m: 0.02}
    material: {law: neo_hookean, neo_hookean_Pa: 1.0e+7, bulk_Pa: 1.0e+8, density_kg_per_m3: 1000}
    integrator: {rho_inf: 1, tolerance_m: 1.0e-12}
    velocity: {linear_m_per_s: [1, 0, 0]}
    watch: [{name: top, at: 0}, {name: bottom, at: 0.5}]
)",
                                 "transient");
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* point : {"top", "bottom"}) {
    const auto u = outcome.results["history"]["displacement_m"][point].back();
    // The method integrates a constant acceleration exactly.
    EXPECT_NEAR(u[0].get<double>(), 0.1, 1e-9) << point;
    EXPECT_NEAR(u[1].get<double>(), 0.0, 1e-9) << point;
    EXPECT_NEAR(u[2].get<double>(), -0.5 * 9.81 * 0.01, 1e-9) << point;
  }
  std::ifstream vtu(folder_ / "fem" / "fem_000100.vtu");
  const std::string text((std::istreambuf_iterator<char>(vtu)), std::istreambuf_iterator<char>());
  // Twelve elements in four slices of four corners each, and one more at the end.
  EXPECT_NE(text.find("NumberOfPoints=\"240\" NumberOfCells=\"48\""), std::string::npos);
  for (const char* array : {"velocity_m_per_s", "axial_strain", "contact_pressure_Pa"}) {
    EXPECT_NE(text.find("Name=\"" + std::string(array) + "\""), std::string::npos) << array;
  }
}

TEST_F(AncfCommand, HangingRopeStretchesUnderItsWeight) {
  const auto stretch_with = [&](int elements) {
    const FemOutcome outcome = run(R"(name: rope
fem:
  model: ancf
  gravity_m_per_s2: [0, 0, -9.81]
  analysis: {load_steps: 1}
  ancf:
    path: {kind: line, direction: [0, 0, -1], length_m: 2}
    chain: {elements: )" + std::to_string(elements) +
                                       R"(, left_support: clamped}
    section: {width_m: 0.01, height_m: 0.01}
    material: {law: svk, young_Pa: 1.0e+7, poisson: 0, density_kg_per_m3: 1000}
    watch: [{name: end, at: 1}]
)",
                                   "static");
    EXPECT_EQ(outcome.exit_code, 0);
    return -outcome.results["load_steps"].back()["displacement_m"]["end"][2].get<double>();
  };
  // ρ g L²/(2 E); the law takes 1.5 times the strain of at most 2e-3 of it. The clamp holds r_x
  // too: the first of n elements, with 2/n of the whole stretch, lacks a quarter of its own or
  // less.
  const double stretch = 1000.0 * 9.81 * 4.0 / (2.0 * 1e7);
  const double coarse = stretch_with(64);
  const double fine = stretch_with(128);
  EXPECT_NEAR(coarse, stretch, 2.0 / 64.0 / 4.0 * stretch);
  EXPECT_NEAR(2.0 * fine - coarse, stretch, 1.5 * 2e-3 * stretch);
}

TEST_F(AncfCommand, KeysOfTheOtherModelAreRefused) {
  std::string both = kCantilever;
  both += "  material: {young_Pa: 1, poisson: 0, density_kg_per_m3: 1}\n";
  try {
    run(both, "static");
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("model"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace tandem::orchestrator
