#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/tandem_process.h"

// What a run says of itself: terminal, summary.json, report.
namespace tandem::test {
namespace {

using nlohmann::json;

struct Judged {
  Ended ended;
  json summary;
  [[nodiscard]] std::vector<std::string> causes() const {
    std::vector<std::string> names;
    for (const json& cause : summary.at("verdict").at("causes")) names.push_back(cause.at("name"));
    return names;
  }
};

Judged judged(const std::string& example, const std::vector<std::string>& more,
              const TemporaryFolder& folder, const std::string& transport = "inproc") {
  std::vector<std::string> arguments = {"--transport", transport};
  arguments.insert(arguments.end(), more.begin(), more.end());
  Judged run{.ended = run_command(run_of(example, folder / "run", arguments)), .summary = {}};
  run.summary = summary_of(folder / "run");
  return run;
}

const std::vector<std::string> kSecondOrder = {"--set", "mbs.integrator=verlet", "--set",
                                               "fem.integrator.kind=generalised_alpha"};

std::vector<std::string> with(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(RunVerdict, NamesTheLossOfBackwardEulerAndItsRemedyHelps) {
  const TemporaryFolder first;
  const Judged lossy = judged("two_masses", {}, first);
  EXPECT_EQ(lossy.ended.code, 0);
  EXPECT_EQ(lossy.summary.at("status"), "done");
  EXPECT_EQ(lossy.summary.at("verdict").at("status"), "done, but");
  EXPECT_EQ(lossy.causes(), std::vector<std::string>{"numerical_loss"});
  EXPECT_NE(lossy.ended.output.find("verdict: done, but"), std::string::npos) << lossy.ended.output;
  EXPECT_NE(lossy.ended.output.find("mbs.integrator: verlet"), std::string::npos);

  const TemporaryFolder second;
  const Judged sound =
      judged("two_masses", with(kSecondOrder, {"--set", "run.duration_s=0.3"}), second);
  EXPECT_TRUE(sound.causes().empty()) << sound.ended.output;
  EXPECT_NE(sound.ended.output.find("verdict: done\n"), std::string::npos) << sound.ended.output;
}

TEST(RunVerdict, NamesTheLossOfTheReducedPendulum) {
  const TemporaryFolder first;
  const Judged reduced = judged("pendulum_beam", {"--set", "fem.formulation=craig_bampton"}, first);
  ASSERT_EQ(reduced.ended.code, 0) << reduced.ended.output;
  EXPECT_EQ(reduced.causes(), (std::vector<std::string>{"numerical_loss", "elastic_turn"}));
  EXPECT_NE(reduced.ended.output.find("instead of fem.formulation: craig_bampton"),
            std::string::npos)
      << reduced.ended.output;
  const TemporaryFolder second;
  EXPECT_TRUE(judged("pendulum_beam", {}, second).causes().empty());
}

// Nothing but round-off goes over the interface, and grows by any factor: no divergence.
TEST(RunVerdict, TakesFreeFallForNoDivergence) {
  const TemporaryFolder folder;
  const Ended ended =
      run_command({kTandem, "run",
                   std::string(TANDEM_SOURCE_DIR) + "/tests/data/coupled/systems/free_fall.yaml",
                   "--transport", "inproc", "--quiet", "--out", (folder / "run").string()});
  EXPECT_EQ(ended.code, 0) << ended.output;
  EXPECT_EQ(summary_of(folder / "run").at("status"), "done");
}

// At 8 ms the crank's pin misses its circle by h² w² r / (2 erp): 5.7 mm of 100 mm.
TEST(RunVerdict, NamesJointsThatComeApart) {
  const TemporaryFolder first;
  const Judged torn = judged("slider_crank", {"--set", "run.macro_step_s=0.008"}, first);
  ASSERT_EQ(torn.ended.code, 0) << torn.ended.output;
  const auto& widest = torn.summary.at("widest_joint");
  EXPECT_NEAR(widest.at("gap_m").get<double>(), 5.7e-3, 1.5e-3);
  const std::vector<std::string> causes = torn.causes();
  EXPECT_NE(std::find(causes.begin(), causes.end(), "joint_gap"), causes.end());
  EXPECT_NE(torn.ended.output.find("joint 'crank_pin' came apart by up to"), std::string::npos)
      << torn.ended.output;
  const TemporaryFolder second;
  EXPECT_TRUE(judged("slider_crank", {}, second).causes().empty());
}

// Ten times the density, explicit, second order: below the monitor's limit, but the energy grows.
TEST(RunVerdict, NamesEnergyThatAnExplicitSchemeMakes) {
  const std::vector<std::string> heavy =
      with(kSecondOrder,
           {"--set", "fem.material.density_kg_per_m3=10000", "--set", "run.macro_step_s=0.0005",
            "--set", "run.duration_s=0.4", "--set", "coupling.prediction=hold"});
  const TemporaryFolder first;
  const Judged growing = judged("two_masses", with(heavy, {"--scheme", "explicit_serial"}), first);
  ASSERT_EQ(growing.ended.code, 0) << growing.ended.output;
  EXPECT_EQ(growing.causes(), std::vector<std::string>{"energy_growth"});
  EXPECT_NE(growing.ended.output.find("use coupling.scheme: interface_jacobian"),
            std::string::npos);
  const TemporaryFolder second;
  EXPECT_TRUE(judged("two_masses", heavy, second).causes().empty());
}

TEST(RunVerdict, NamesATurnThatAStepDoesNotResolve) {
  const TemporaryFolder first;
  const Judged fast = judged("rotor", {"--set", "run.macro_step_s=0.0025"}, first);
  EXPECT_EQ(fast.ended.code, 0);
  EXPECT_NEAR(fast.summary.at("largest_turn").at("rad").get<double>(), 0.25, 1e-3);
  const auto causes = fast.causes();
  EXPECT_NE(std::find(causes.begin(), causes.end(), "turn_per_step"), causes.end());
  EXPECT_NE(fast.ended.output.find("port 'root' turns by up to 0.25 rad"), std::string::npos)
      << fast.ended.output;
  const TemporaryFolder second;
  EXPECT_TRUE(judged("rotor", {}, second).causes().empty());
}

/// two_masses with one more body, which carries no port and spins with so many rad/s.
std::filesystem::path with_flywheel(const TemporaryFolder& folder, const std::string& rate) {
  std::string text = read_file(kExamples + "two_masses/scenario.yaml");
  const std::string list = "  bodies:\n";
  text.insert(text.find(list) + list.size(),
              "    - {name: flywheel, mass_kg: 1, inertia_kg_m2: [1.0e-9, 1.0e-9, 1.0e-9], "
              "position_m: [0, 0, 1], angular_velocity_rad_per_s: [0, 0, " +
                  rate + "]}\n");
  const std::string mesh = "bar.msh";
  text.replace(text.find(mesh), mesh.size(), kExamples + "two_masses/bar.msh");
  write_file(folder / "flywheel.yaml", text);
  return folder / "flywheel.yaml";
}

TEST(RunVerdict, SeesBodiesWithoutAPort) {
  const auto output_at = [](const std::string& rate) {
    const TemporaryFolder folder;
    const Ended ended = tandem_command({"run", with_flywheel(folder, rate).string(), "--quiet",
                                        "--transport", "inproc", "--set", "run.duration_s=0.05",
                                        "--out", (folder / "run").string()});
    EXPECT_EQ(ended.code, 0) << ended.output;
    return ended.output;
  };
  EXPECT_NE(output_at("250").find("body 'flywheel' turns by up to 0.25 rad"), std::string::npos);
  EXPECT_EQ(output_at("150").find("turns by up to"), std::string::npos);
}

TEST(RunVerdict, NamesStepsThatWereAcceptedWithoutHavingConverged) {
  const TemporaryFolder folder;
  const Judged capped =
      judged("lug",
             {"--set", "run.duration_s=0.05", "--scheme", "implicit", "--set",
              "coupling.max_iterations=3", "--set", "coupling.on_not_converged=accept"},
             folder);
  ASSERT_EQ(capped.ended.code, 0) << capped.ended.output;
  const auto causes = capped.causes();
  ASSERT_FALSE(causes.empty());
  EXPECT_EQ(causes.front(), "not_converged_steps");
}

// Both transports have the same books, down to the last bit.
TEST(RunVerdict, IsTheSameOverLcm) {
  const std::vector<std::string> shorter = {"--set", "run.duration_s=0.1"};
  const TemporaryFolder here;
  const TemporaryFolder there;
  const json a = judged("two_masses", shorter, here).summary;
  const json b = judged("two_masses", shorter, there, "lcm").summary;
  EXPECT_EQ(a.at("verdict"), b.at("verdict"));
  EXPECT_EQ(a.at("energy_J"), b.at("energy_J"));
}

TEST(RunVerdict, StandsInTheReport) {
  const TemporaryFolder folder;
  (void)judged("rotor", {"--set", "run.macro_step_s=0.0025"}, folder);
  const Ended ended = tandem_command(
      {"report", (folder / "run").string(), "--out", (folder / "page.html").string()});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const std::string page = read_file(folder / "page.html");
  EXPECT_NE(page.find("Verdict: done, but."), std::string::npos);
  EXPECT_NE(page.find("port 'root' turns by up to"), std::string::npos);
}

// Steel that rings in backward Euler, alone.
TEST(FemVerdict, EndsATransientOfTheFlexibleSideAlone) {
  const TemporaryFolder folder;
  const std::string scenario = kExamples + "hinge/scenario.yaml";
  const auto verdict_with = [&](const std::string& kind, const std::string& name) {
    const Ended ended =
        tandem_command({"fem", scenario, "--analysis", "transient", "--set", "run.duration_s=0.004",
                        "--set", "fem.integrator.kind=" + kind, "--set",
                        "fem.integrator.newton_steps=20", "--out", (folder / name).string()});
    EXPECT_EQ(ended.code, 0) << ended.output;
    return json::parse(read_file(folder / name / "fem.json")).at("verdict");
  };
  EXPECT_EQ(verdict_with("backward_euler", "a").at("causes").at(0).at("name"), "numerical_loss");
  EXPECT_EQ(verdict_with("generalised_alpha", "b").at("status"), "done");
}

}  // namespace
}  // namespace tandem::test
