// The candidates of tandem advise: what a scenario's sides allow, as settings that load.
#include "orchestrator/advise/candidates.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "orchestrator/verdict/run_books.h"

namespace tandem::orchestrator {
namespace {

Model load(const std::string& example, const Settings& settings = {}) {
  // With an accuracy that leaves the exact solver and fresh Jacobians, for the others to be
  // offered.
  std::vector<scenario::Override> overrides{{"run.accuracy", "1e-10"}};
  for (const std::string& setting : settings) {
    overrides.push_back(scenario::parse_override(setting));
  }
  return load_model(std::string(TANDEM_SOURCE_DIR) + "/examples/" + example + ".yaml", overrides);
}

bool rigid_second(const Model& model) {
  return model.scenario.root.section("mbs").text("integrator") != "euler";
}

bool flexible_second(const Model& model) {
  return is_second_order(model.scenario.root.section("fem"));
}

std::vector<std::string> names_of(const std::vector<IntegratorPair>& pairs) {
  std::vector<std::string> names;
  for (const IntegratorPair& pair : pairs) names.push_back(pair.name);
  return names;
}

using Names = std::vector<std::string>;

TEST(AdviseCandidates, OffersTheOtherOrderAndBothSidesHaveIt) {
  const std::vector<IntegratorPair> lug = integrator_pairs(load("lug/scenario"));
  ASSERT_EQ(names_of(lug), (Names{"own", "second order"}));
  EXPECT_EQ(lug[0].order, 1);
  const Model second = load("lug/scenario", lug[1].settings);
  EXPECT_TRUE(rigid_second(second) && flexible_second(second));
  // What the file says of iterations stays, and the keys of the other integrator go.
  const Settings newmark = {"fem.integrator={kind: newmark, newmark_beta: 0.3, newton_steps: 7}",
                            "mbs.integrator=verlet"};
  const Model given = load("lug/scenario", newmark);
  const std::vector<IntegratorPair> back = integrator_pairs(given);
  ASSERT_EQ(names_of(back), (Names{"own", "first order"}));
  EXPECT_EQ(back[0].order, 2);
  const Model first = load("lug/scenario", joined(newmark, back[1].settings));
  EXPECT_FALSE(rigid_second(first) || flexible_second(first));
  EXPECT_EQ(first.scenario.root.section("fem").section("integrator").integer("newton_steps"), 7);
}

TEST(AdviseCandidates, OffersBothOrdersWhereTheSidesDiffer) {
  const Settings mixed = {"fem.integrator={kind: hht, hht_alpha: 0}"};
  const std::vector<IntegratorPair> pairs = integrator_pairs(load("lug/scenario", mixed));
  ASSERT_EQ(names_of(pairs), (Names{"own", "second order", "first order"}));
  EXPECT_EQ(pairs[0].order, 1);
  const Model second = load("lug/scenario", joined(mixed, pairs[1].settings));
  EXPECT_TRUE(rigid_second(second) && flexible_second(second));
  const Model first = load("lug/scenario", joined(mixed, pairs[2].settings));
  EXPECT_FALSE(rigid_second(first) || flexible_second(first));
}

TEST(AdviseCandidates, ChangesTheMultibodySideAloneWhereTheOtherHasNoChoice) {
  for (const char* example : {"belt_drive/scenario", "bar15/scenario"}) {
    const std::vector<IntegratorPair> pairs = integrator_pairs(load(example));
    ASSERT_EQ(names_of(pairs), (Names{"own", "second order"})) << example;
    EXPECT_EQ(pairs[1].settings, Settings{"mbs.integrator=verlet"}) << example;
    EXPECT_TRUE(rigid_second(load(example, pairs[1].settings))) << example;
  }
}

TEST(AdviseCandidates, IteratesWithTheAcceleratorOfTheFewestEvaluationsUnlessItIsTheScenarios) {
  const IntegratorPair own;
  const Model model = load("lug/scenario");
  const Model changed = load("lug/scenario", make_candidate(model, "implicit", own).settings);
  EXPECT_EQ(changed.coupling.scheme, SchemeKind::Implicit);
  EXPECT_EQ(changed.coupling.relaxation, Relaxation::IqnIls);
  EXPECT_TRUE(make_candidate(changed, "implicit", own).settings.empty());
}

// One rule for a run's own choice and for what is offered.
TEST(AdviseCandidates, InnerToleranceIsThatOfRunAccuracy) {
  const auto inner = [](const Settings& settings) {
    const Model model = load("lug/scenario", settings);
    for (const SolverChange& change : solver_changes(model)) {
      if (change.name != "PCG") continue;
      return load("lug/scenario", joined(settings, change.settings))
          .scenario.root.section("fem")
          .section("solver")
          .real("tolerance");
    }
    return 0.0;
  };
  const std::string direct = "fem.solver.kind=cholmod";
  EXPECT_EQ(inner({direct, "run.accuracy=1e-6"}), 1e-10);
  EXPECT_EQ(inner({direct, "run.accuracy=1e-8"}), 1e-12);
  EXPECT_EQ(inner({direct, "run.accuracy=1e-12"}), 1e-13);
  EXPECT_EQ(inner({direct, "run.accuracy=1e-6", "coupling.scheme=explicit_serial"}), 1e-10);
}

TEST(AdviseCandidates, SolverSettingsAreThoseThatTheModelHas) {
  const auto changes = [](const std::string& example, const Settings& settings) {
    Names names;
    for (const SolverChange& change : solver_changes(load(example, settings))) {
      (void)load(example, joined(settings, change.settings));  // it loads
      names.push_back(change.name);
    }
    return names;
  };
  EXPECT_EQ(changes("lug/scenario", {}), (Names{"PCG", "Broyden's Jacobian"}));
  EXPECT_EQ(changes("lug/scenario", {"fem.solver={kind: pcg, tolerance: 1e-9}",
                                     "coupling.jacobian.fem_refresh=broyden"}),
            (Names{"CHOLMOD", "Jacobian at every step"}));
  // With micro steps the flexible side's Jacobian is kept by itself.
  EXPECT_EQ(changes("lug/scenario", {"fem.micro_step_s=2.5e-4"}),
            (Names{"PCG", "Jacobian at every step"}));
  EXPECT_EQ(changes("lug/scenario", {"coupling.scheme=explicit_serial"}), (Names{"PCG"}));
  EXPECT_EQ(changes("bar15/scenario", {}), Names{});
  EXPECT_EQ(changes("rope_crane/scenario", {}), (Names{"Broyden's Jacobian"}));
}

TEST(AdviseCandidates, StepsKeepTheNumberOfMicroSteps) {
  const Model model = load("lug/scenario", {"fem.micro_step_s=2.5e-4", "mbs.micro_step_s=5e-4"});
  const Model longer = load("lug/scenario", step_settings(model, 2e-3));
  EXPECT_EQ(to_seconds(longer.run.macro_step), 2e-3);
  EXPECT_EQ(longer.scenario.root.section("mbs").real("micro_step_s"), 1e-3);
  EXPECT_EQ(longer.scenario.root.section("fem").real("micro_step_s"), 5e-4);
  EXPECT_EQ(step_settings(load("lug/scenario"), 2e-3), Settings{"run.macro_step_s=0.002"});
}

TEST(AdviseCandidates, AdaptiveStepsAreTheScenariosOwn) {
  EXPECT_TRUE(own_settings(load("lug/scenario")).empty());
  EXPECT_EQ(own_settings(load("lug/scenario", {"coupling.adaptive.tolerance=1e-3"})),
            Settings{"coupling.adaptive.tolerance=0.001"});
}

}  // namespace
}  // namespace tandem::orchestrator
