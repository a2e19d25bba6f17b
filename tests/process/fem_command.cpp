#include "orchestrator/commands/fem_command.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>

#include "orchestrator/scenario/scenario_table.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

namespace fs = std::filesystem;

class FemCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::path(::testing::TempDir()) /
             (std::string("fem_command_") +
              ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  /// The 15-tet bar under an end load, in as few sections as the command needs.
  [[nodiscard]] scenario::Loaded load(const std::string& more = "",
                                      const std::vector<scenario::Override>& changes = {}) const {
    const fs::path file = folder / "bar.yaml";
    std::ofstream(file) << "name: bar\nfem:\n  mesh: {file: " << TANDEM_SOURCE_DIR
                        << "/tests/data/fem/beam15.msh}\n"
                           "  material: {young_Pa: 1e6, poisson: 0.3, density_kg_per_m3: 1000}\n"
                           "  fixed: [fixed]\n"
                           "  loads: [{kind: surface, set: load, force_N: [100, 50, -12.5]}]\n"
                           "  watch: [monitor, load]\n"
                        << more;
    return scenario::load(file, fem_scenario_table(), changes);
  }
  fs::path folder;
};

TEST_F(FemCommand, NeedsNoOtherSectionThanFem) {
  const FemOutcome outcome = run_fem(load().root, "", folder);
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.results["analysis"], "static");
  EXPECT_EQ(outcome.results["nodes"], 16);
  EXPECT_EQ(outcome.results["elements"], 15);
  ASSERT_EQ(outcome.results["load_steps"].size(), 10U);
  const auto& last = outcome.results["load_steps"][9];
  EXPECT_EQ(last["factor"], 1.0);
  EXPECT_GT(last["iterations"], 1);
  EXPECT_EQ(last["displacement_m"]["monitor"].size(), 3U);
  EXPECT_EQ(last["displacement_m"]["load"].size(), 3U);
  EXPECT_TRUE(fs::exists(folder / "fem" / "fem_000009.vtu"));
  EXPECT_TRUE(fs::exists(folder / "fem" / "fem.pvd"));
}

// fem.json has the numbers; the terminal has sentences with units.
TEST_F(FemCommand, PrintsSentencesWithUnits) {
  ::testing::internal::CaptureStdout();
  static_cast<void>(run_fem(load("  analysis: {load_factors: [0.5]}\n").root, "", folder));
  const std::string printed = ::testing::internal::GetCapturedStdout();
  const std::regex sentence(
      "load factor 0\\.5: \\d+ iterations, residual \\S+ of the load, mean displacement of "
      "'monitor' "
      "\\((\\S+, ){2}\\S+\\) m, of 'load' \\((\\S+, ){2}\\S+\\) m\n");
  EXPECT_TRUE(std::regex_match(printed, sentence)) << printed;
}

TEST_F(FemCommand, SaysThatNothingIsWatched) {
  ::testing::internal::CaptureStdout();
  static_cast<void>(run_fem(load("", {{"fem.watch", "[]"}}).root, "", folder));
  const std::string printed = ::testing::internal::GetCapturedStdout();
  EXPECT_NE(printed.find("no mean displacement is asked for (fem.watch)"), std::string::npos)
      << printed;
}

// A change that no macro step would make is refused where it stands, in line 9.
TEST_F(FemCommand, RefusesChangesAfterTheLastStep) {
  const std::string run = "run: {duration_s: 0.05, macro_step_s: 0.005}\n";
  const auto changed = [&](const std::string& at_s) {
    return load("  changes:\n    - {at_s: " + at_s + ", release: fixed}\n" + run);
  };
  EXPECT_EQ(run_fem(changed("0.045").root, "transient", folder).exit_code, 0);
  for (const std::string at_s : {"0.046", "0.05", "7"}) {
    try {
      static_cast<void>(run_fem(changed(at_s).root, "transient", folder));
      ADD_FAILURE() << at_s;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Usage);
      const std::string text = error.what();
      EXPECT_TRUE(text.starts_with((folder / "bar.yaml").string() + ":9:14: ")) << text;
      EXPECT_NE(text.find("run.duration_s"), std::string::npos) << text;
    }
  }
}

TEST_F(FemCommand, TakesTheLoadFactorsOfTheScenario) {
  const FemOutcome outcome =
      run_fem(load("  analysis: {load_factors: [0.5, -0.25, 0]}\n").root, "", folder);
  ASSERT_EQ(outcome.results["load_steps"].size(), 3U);
  EXPECT_EQ(outcome.results["load_steps"][1]["factor"], -0.25);
  // Elastic: without load it is back where it began, to the round-off of the residual.
  for (double u : outcome.results["load_steps"][2]["displacement_m"]["load"]) {
    EXPECT_NEAR(u, 0.0, 1e-7);
  }
}

TEST_F(FemCommand, WritesFrequenciesAndModeShapes) {
  const FemOutcome outcome = run_fem(load("  analysis: {modes: 4}\n").root, "modes", folder);
  EXPECT_EQ(outcome.results["frequencies_Hz"].size(), 4U);
  EXPECT_TRUE(fs::exists(folder / "fem" / "mode_000003.vtu"));
}

TEST_F(FemCommand, WritesTheHistoryFromRestOn) {
  const FemOutcome outcome =
      run_fem(load("run: {duration_s: 0.05, macro_step_s: 0.005}\n").root, "transient", folder);
  const auto& history = outcome.results["history"];
  ASSERT_EQ(history["t_s"].size(), 11U);
  EXPECT_EQ(history["t_s"][10], 0.05);
  ASSERT_EQ(history["displacement_m"]["load"].size(), 11U);
  EXPECT_EQ(history["displacement_m"]["load"][0][0], 0.0);
  EXPECT_GT(history["displacement_m"]["load"][10][0], 0.0);  // along the load
}

TEST_F(FemCommand, SaysThatATransientAnalysisNeedsTheSectionRun) {
  try {
    static_cast<void>(run_fem(load().root, "transient", folder));
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("needs the section 'run'"), std::string::npos);
  }
}

// Its stiffness is singular, which no step size mends.
TEST_F(FemCommand, AStaticBodyThatIsNotHeldIsBadInput) {
  const auto refused = [](const Error& error, const std::string& words) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find("micro_step"), std::string::npos) << error.what();
  };
  for (const char* solver : {"cholmod", "pcg"}) {
    try {
      static_cast<void>(
          run_fem(load("", {{"fem.fixed", "[]"}, {"fem.solver.kind", solver}}).root, "", folder));
      ADD_FAILURE() << "accepted by " << solver;
    } catch (const Error& error) {
      refused(error, "the body is not held against rigid motion");
      refused(error, "three that are not in line. Name a node set in fem.fixed");
    }
  }
}

// Two tets that share no node, one of them held: said with a node of the other.
TEST_F(FemCommand, APartThatHangsInTheAirIsNamed) {
  std::ofstream(folder / "two.inp") << "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n"
                                       "15, 5, 0, 0\n16, 6, 0, 0\n17, 5, 1, 0\n18, 5, 0, 1\n"
                                       "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n2, 15, 16, 17, 18\n"
                                       "*NSET, NSET=FLOOR\n1, 2, 3\n*NSET, NSET=EDGE\n15, 16\n";
  const auto loaded = [&](const std::string& fixed) {
    return load("", {{"fem.mesh.file", (folder / "two.inp").string()},
                     {"fem.fixed", fixed},
                     {"fem.loads", "[]"},
                     {"fem.watch", "[]"}});
  };
  try {
    static_cast<void>(run_fem(loaded("[FLOOR, EDGE]").root, "", folder));
    FAIL() << "accepted";
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("a part of the body (4 of its 8 nodes, among them node 15 of "),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("have 2 of its nodes"), std::string::npos) << text;
  }
}

// An equilibrium that is not found is exit code 3, with the load factor and what to do.
// The port stands in line 10 of the file, behind a dash in column 3.
TEST_F(FemCommand, RefusesPortsOnBushingsInEveryAnalysisAndSaysWhere) {
  const std::string port =
      "run: {duration_s: 0.01, macro_step_s: 0.001}\n"
      "ports:\n  - {name: end, body: arm, node_set: monitor, attachment: bushing,\n"
      "     bushing: {stiffness_N_per_m: [1, 1, 1]}}\n";
  for (const char* analysis : {"static", "quasi_static", "modes", "transient"}) {
    try {
      static_cast<void>(run_fem(load(port).root, analysis, folder));
      ADD_FAILURE() << analysis << " accepts a bushing";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Usage);
      EXPECT_EQ(
          std::string(error.what()),
          (folder / "bar.yaml").string() +
              ":10:5: port 'end' is not rigid, and `tandem fem` holds and moves port nodes as "
              "rigid sets. Add --set ports.end.attachment=rigid, or use `tandem run`.")
          << analysis;
    }
  }
}

TEST_F(FemCommand, ReportsAMissingEquilibrium) {
  const FemOutcome outcome =
      run_fem(load("  analysis: {max_iterations: 1, safeguards: false}\n").root, "", folder);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(outcome.results["status"], "not_converged");
  EXPECT_NE(outcome.results["message"].get<std::string>().find("load factor"), std::string::npos);
}

}  // namespace
}  // namespace tandem::orchestrator
