// tandem compare --steps and tandem advise as users start them.

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/support/tandem_process.h"

namespace tandem::test {
namespace {

nlohmann::json results_of(const std::filesystem::path& file) {
  return nlohmann::json::parse(read_file(file));
}

TEST(CompareSteps, ErrorsFallWithOrderOneAndConvergedSchemesEqualTheMonolithicRun) {
  const TemporaryFolder folder("tandem_steps");
  const Ended ended =
      tandem_command({"compare", kExamples + "pendulum_beam/scenario.yaml", "--schemes",
                      "explicit_serial,interface_jacobian", "--steps", "2e-4,1e-4", "--transport",
                      "inproc", "--set", "run.duration_s=0.02", "--out", (folder / "c").string()});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const nlohmann::json json = results_of(folder / "c/compare.json");
  std::map<std::string, std::vector<double>> errors;
  for (const auto& row : json.at("rows")) {
    EXPECT_EQ(row.at("status"), "done");
    errors[row.at("scheme")].push_back(row.at("error_motion_m"));
  }
  ASSERT_EQ(errors.size(), 3U);
  for (const auto& [scheme, error] : errors) {
    ASSERT_EQ(error.size(), 2U);
    // Order 1 against a reference at H_min/8: (2 − 1/8)/(1 − 1/8) = 2.14 and terms of order H;
    // order 2 would give 4.05.
    EXPECT_NEAR(error[0] / error[1], 2.14, 0.15) << scheme;
  }
  // The reference's own error is a seventh of that of the smallest step.
  EXPECT_NEAR(json.at("reference").at("error_estimate_m").get<double>(),
              errors["monolithic"][1] / 7.0, 0.2 * errors["monolithic"][1] / 7.0);
  // interface_jacobian solves the same equations to 1e-12 of the wrenches.
  EXPECT_NEAR(errors["interface_jacobian"][1], errors["monolithic"][1],
              1e-6 * errors["monolithic"][1]);
  for (const char* file : {"c/compare.csv", "c/compare.svg", "c/compare.txt"}) {
    EXPECT_GT(read_file(folder / file).size(), 100U) << file;
  }
}

TEST(CompareSteps, AdaptiveRunsStandBesideFixedOnes) {
  const TemporaryFolder folder("tandem_steps");
  const Ended ended = tandem_command(
      {"compare", kExamples + "pendulum_beam/scenario.yaml", "--steps", "1e-3", "--tolerances",
       "0.1,0.001", "--transport", "inproc", "--set", "run.duration_s=0.05", "--set",
       "coupling.adaptive.tolerance=0.5", "--out", (folder / "c").string()});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const nlohmann::json rows = results_of(folder / "c/compare.json").at("rows");
  ASSERT_EQ(rows.size(), 4U);  // monolithic, fixed, two tolerances
  EXPECT_EQ(rows[1].at("macro_steps"), 50);
  EXPECT_EQ(rows[1].at("adaptive_tolerance"), 0.0);
  EXPECT_EQ(rows[2].at("adaptive_tolerance"), 0.1);
  EXPECT_NEAR(rows[2].at("macro_step_s").get<double>() * rows[2].at("macro_steps").get<double>(),
              0.05, 1e-12);
  EXPECT_GT(rows[3].at("macro_steps"), rows[2].at("macro_steps"));
  EXPECT_LT(rows[3].at("error_motion_m"), rows[2].at("error_motion_m"));
}

TEST(CompareSteps, RunThatDivergesIsARowWithItsReason) {
  const TemporaryFolder folder("tandem_steps");
  const Ended ended = tandem_command({"compare", kExamples + "two_masses/scenario.yaml",
                                      "--schemes", "explicit_serial", "--steps", "0.01",
                                      "--transport", "inproc", "--out", (folder / "c").string()});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const nlohmann::json row = results_of(folder / "c/compare.json").at("rows").back();
  EXPECT_EQ(row.at("status"), "diverged");
  EXPECT_NE(row.at("message").get<std::string>().find("port '"), std::string::npos);
  EXPECT_NE(ended.output.find("diverged, see below"), std::string::npos) << ended.output;
}

TEST(CompareSteps, StepThatDoesNotDivideTheDurationIsRefusedBeforeAnyRun) {
  const TemporaryFolder folder("tandem_steps");
  const Ended ended =
      tandem_command({"compare", kExamples + "two_masses/scenario.yaml", "--steps", "1e-3,3e-4",
                      "--transport", "inproc", "--out", (folder / "c").string()});
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_NE(ended.output.find("not a whole number of macro steps of 0.0003 s"), std::string::npos)
      << ended.output;
}

TEST(Compare, SchemeNamedTwiceIsRefusedBeforeAnyRun) {
  const TemporaryFolder folder("tandem_twice");
  const Ended ended =
      tandem_command({"compare", kExamples + "two_masses/scenario.yaml", "--schemes",
                      "implicit,implicit", "--out", (folder / "c").string()});
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_NE(ended.output.find("implicit is named twice"), std::string::npos) << ended.output;
}

TEST(Advise, BracketsTheLimitOfTheExplicitSchemeAndRecommendsAStepBelowIt) {
  const TemporaryFolder folder("tandem_advise");
  const Ended ended =
      tandem_command({"advise", kExamples + "two_masses/scenario.yaml", "--trial-steps", "20",
                      "--check-s", "10", "--out", (folder / "a").string()});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const nlohmann::json json = results_of(folder / "a/advise.json");
  const auto& limit = json.at("explicit_stability");
  // The prediction is the safe one; runs of the scenario itself confirm both ends of the bracket.
  EXPECT_LE(limit.at("predicted_s").get<double>(), limit.at("unstable_s").get<double>());
  for (const char* end : {"stable_s", "unstable_s"}) {
    const double step_s = limit.at(end).get<double>();
    const Ended run = tandem_command(
        {"run", kExamples + "two_masses/scenario.yaml", "--scheme", "explicit_serial",
         "--transport", "inproc", "--set", "run.macro_step_s=" + limit.at(end).dump(), "--set",
         "run.duration_s=" + std::to_string(400 * step_s), "--out", (folder / end).string()});
    EXPECT_EQ(run.code, std::string(end) == "stable_s" ? 0 : 3) << run.output;
  }
  // The bar is light against the bodies: one exchange per step is enough.
  const auto& recommended = json.at("recommended");
  EXPECT_EQ(recommended.at("scheme"), "explicit_serial");
  EXPECT_LT(recommended.at("macro_step_s").get<double>(), limit.at("stable_s").get<double>());
  EXPECT_NE(ended.output.find("recommended: "), std::string::npos) << ended.output;
}

// The printed command does what the advice says of it: the same verdict, an error within what was
// asked for by runs of its own, and a cost beside that of the scenario's own settings.
TEST(Advise, PrintsACommandThatDoesWhatItSays) {
  const TemporaryFolder folder("tandem_advise");
  const std::string scenario = kExamples + "pendulum_beam/scenario.yaml";
  const Ended ended =
      tandem_command({"advise", scenario, "--accuracy", "1e-2", "--trial-steps", "50", "--set",
                      "run.duration_s=0.4", "--most-s", "40", "--out", (folder / "a").string()});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const nlohmann::json json = results_of(folder / "a/advise.json");
  const auto& recommended = json.at("recommended");
  ASSERT_TRUE(json.at("check").at("whole_run").get<bool>()) << ended.output;
  const auto& measured = recommended.at("measured");
  EXPECT_LE(measured.at("error").get<double>(), 1e-2);
  EXPECT_GT(measured.at("wall_s_per_simulated_s").get<double>(), 0.0);

  const std::size_t at = ended.output.find("  tandem run ");
  ASSERT_NE(at, std::string::npos) << ended.output;
  const std::string line = ended.output.substr(at + 2, ended.output.find('\n', at + 2) - at - 2);
  const auto run = [&](const std::string& name, const std::string& more) {
    const std::string command = without_spaces(TANDEM_BIN_DIR) + "/" + line + more +
                                " --quiet --transport inproc --out " + (folder / name).string();
    return run_command({"/bin/sh", "-c", command}, {}, 120.0);
  };
  const Ended printed = run("printed", "");
  ASSERT_EQ(printed.code, 0) << line << "\n" << printed.output;
  const nlohmann::json summary = summary_of(folder / "printed");
  EXPECT_EQ(summary.at("verdict").at("status"), measured.at("verdict").at("status"));
  EXPECT_EQ(summary.at("scheme"), recommended.at("scheme"));
  // A quarter of the step, as a reference: the end of the run is within the error over all of it.
  const double step_s = recommended.at("macro_step_s");
  const Ended fine = run("fine", " --set run.macro_step_s=" + nlohmann::json(step_s / 4).dump());
  ASSERT_EQ(fine.code, 0) << fine.output;
  const auto end_of = [&](const std::string& name) {
    return summary_of(folder / name).at("ports").begin().value().at("q_WP_wxyz");
  };
  double angle = 0.0;
  for (int i = 0; i < 4; ++i) {
    angle += std::pow(end_of("printed")[i].get<double>() - end_of("fine")[i].get<double>(), 2);
  }
  angle = 2.0 * std::sqrt(angle);
  // The pendulum swings by more than half a radian: a hundredth of that at most, and not by luck 0.
  EXPECT_LT(angle, 1e-2 * 2.0);
  EXPECT_GT(angle, 0.0);
}

// A motor turns the port by an angle that it prescribes, from rest: what trial runs of 0.1 s see of
// it is the same with every step. At 100 rad/s a step of more than 2 ms turns by more than 0.2 rad.
TEST(Advise, BoundsTheStepByTheTurningAtTheEndOfTheRun) {
  const TemporaryFolder folder("tandem_advise");
  const std::string scenario =
      std::string(TANDEM_SOURCE_DIR) + "/tests/data/coupled/systems/spun_bar.yaml";
  const Ended ended = tandem_command({"advise", scenario, "--out", (folder / "a").string()});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const nlohmann::json json = results_of(folder / "a/advise.json");
  const double step_s = json.at("recommended").at("macro_step_s").get<double>();
  EXPECT_LE(step_s, 0.002) << ended.output;
  EXPECT_EQ(json.at("check").at("macro_step_s").get<double>(), step_s);
  EXPECT_TRUE(json.at("check").at("whole_run").get<bool>());
  EXPECT_NE(ended.output.find("rad per step"), std::string::npos) << ended.output;
}

// No time for a run of the scenario's length: said, not passed over.
TEST(Advise, SaysWhatItHadNoTimeToDecide) {
  const TemporaryFolder folder("tandem_advise");
  const Ended ended =
      tandem_command({"advise", kExamples + "two_masses/scenario.yaml", "--trial-steps", "20",
                      "--check-s", "1e-6", "--out", (folder / "a").string()});
  ASSERT_EQ(ended.code, 0) << ended.output;
  EXPECT_NE(ended.output.find("not decided: "), std::string::npos) << ended.output;
  EXPECT_NE(ended.output.find("--check-s"), std::string::npos) << ended.output;
  EXPECT_EQ(results_of(folder / "a/advise.json").at("check").at("macro_step_s"), 0.0);
}

}  // namespace
}  // namespace tandem::test
