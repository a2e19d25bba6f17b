// What is chosen where a scenario leaves tolerances and methods open, and that nothing else is.
#include "orchestrator/scenario/chosen_settings.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "orchestrator/scenario/model.h"

namespace tandem::orchestrator {
namespace {

using Overrides = std::vector<scenario::Override>;
using Settings = std::map<std::string, std::string>;

Model model_of(const std::string& example, const Overrides& overrides) {
  return load_model(std::string(TANDEM_SOURCE_DIR) + "/examples/" + example, overrides);
}

Settings chosen_for(const std::string& example, const Overrides& overrides = {}) {
  Settings settings;
  for (const scenario::Override& setting : model_of(example, overrides).chosen) {
    settings[setting.path] = setting.value;
  }
  return settings;
}

const std::string kTolerance = "coupling.relative_tolerance";
const std::string kSolver = "fem.solver.kind";
const std::string kSolverTolerance = "fem.solver.tolerance";
const std::string kRefresh = "coupling.jacobian.fem_refresh";

TEST(ChosenSettings, FollowFromTheAccuracy) {
  EXPECT_EQ(chosen_for("lug/scenario.yaml"), (Settings{{kTolerance, "1e-07"},
                                                       {kSolver, "pcg"},
                                                       {kSolverTolerance, "1e-10"},
                                                       {kRefresh, "broyden"}}));
  EXPECT_EQ(chosen_for("lug/scenario.yaml", {{"run.accuracy", "1e-4"}}),
            (Settings{{kTolerance, "1e-05"},
                      {kSolver, "pcg"},
                      {kSolverTolerance, "1e-10"},
                      {kRefresh, "broyden"}}));
  EXPECT_EQ(chosen_for("lug/scenario.yaml", {{"run.accuracy", "1e-10"}}),
            (Settings{{kTolerance, "1e-11"}, {kSolver, "cholmod"}}));
}

TEST(ChosenSettings, AreInWhatAllProcessesRead) {
  const Model model = model_of("lug/scenario.yaml", {});
  EXPECT_EQ(model.coupling.relative_tolerance, 1e-7);
  EXPECT_EQ(model.coupling.jacobian.fem_refresh, Refresh::Broyden);
  const scenario::Node solver = model.scenario.root.section("fem").section("solver");
  EXPECT_EQ(solver.text("kind"), "pcg");
  EXPECT_EQ(solver.real("tolerance"), 1e-10);
  // What a replay reads has nothing left open.
  EXPECT_NE(model.scenario.resolved_yaml.find("relative_tolerance: 1e-07"), std::string::npos);
  EXPECT_NE(model.scenario.resolved_yaml.find("kind: \"pcg\""), std::string::npos);
}

TEST(ChosenSettings, LeaveAloneWhatIsSaid) {
  EXPECT_EQ(chosen_for("lug/scenario.yaml", {{kTolerance, "1e-9"},
                                             {kSolver, "pcg"},
                                             {kSolverTolerance, "1e-12"},
                                             {kRefresh, "every_step"}}),
            Settings{});
  EXPECT_EQ(chosen_for("lug/scenario.yaml", {{kSolver, "cholmod"}}),
            (Settings{{kTolerance, "1e-07"}, {kRefresh, "broyden"}}));
}

TEST(ChosenSettings, FactoriseWhereColumnsOrSignsAskForIt) {
  EXPECT_EQ(chosen_for("lug/mounted.yaml").at(kSolver), "cholmod");
  for (const char* formulation : {"corotational_consistent", "total_lagrangian", "linear"}) {
    EXPECT_EQ(chosen_for("lug/scenario.yaml", {{"fem.formulation", formulation}}).at(kSolver),
              "cholmod");
  }
}

TEST(ChosenSettings, SchemesWithoutIterationHaveNoTolerance) {
  EXPECT_EQ(chosen_for("lug/scenario.yaml", {{"coupling.scheme", "explicit_serial"}}),
            (Settings{{kSolver, "pcg"}, {kSolverTolerance, "1e-10"}}));
  EXPECT_EQ(chosen_for("lug/scenario.yaml", {{"coupling.scheme", "implicit"}}),
            (Settings{{kTolerance, "1e-08"}, {kSolver, "pcg"}, {kSolverTolerance, "1e-10"}}));
}

TEST(ChosenSettings, ChainsAndReducedBodiesHaveNoSolver) {
  EXPECT_EQ(chosen_for("belt_drive/scenario.yaml", {{"coupling.scheme", "implicit"}}),
            (Settings{{kTolerance, "1e-08"}}));
  EXPECT_EQ(chosen_for("pendulum_beam/scenario.yaml", {{"fem.formulation", "craig_bampton"}}),
            (Settings{{kTolerance, "1e-07"}}));
}

}  // namespace
}  // namespace tandem::orchestrator
