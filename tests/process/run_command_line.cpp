#include <gtest/gtest.h>

#include "tests/support/tandem_process.h"

// Wrong command lines: exit code 2, what is wrong and what would be right, and nothing written.
namespace tandem::test {
namespace {

struct Line {
  std::string name;
  std::vector<std::string> arguments;
  std::vector<std::string> words;
};
void PrintTo(const Line& line, std::ostream* out) { *out << line.name; }

class WrongCommandLine : public testing::TestWithParam<Line> {};

TEST_P(WrongCommandLine, IsAUsageErrorWithHelp) {
  const TemporaryFolder folder("tandem_line");
  std::vector<std::string> arguments = GetParam().arguments;
  for (std::string& argument : arguments) {
    if (argument == "FOLDER") argument = folder.path().string();
  }
  const Ended ended = tandem_command(arguments);
  EXPECT_EQ(ended.code, 2) << ended.output;
  for (const std::string& words : GetParam().words) {
    EXPECT_NE(ended.output.find(words), std::string::npos)
        << "no '" << words << "': " << ended.output;
  }
  // A refusal is read, not searched: no limits of floating-point numbers written out.
  EXPECT_LT(ended.output.size(), 1000U) << ended.output;
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "something was written";
}

std::vector<Line> lines() {
  const std::string scenario = kExamples + "two_masses/scenario.yaml";
  return {
      {"nothing", {}, {"subcommand", "--help"}},
      {"unknown_command", {"rnu", scenario}, {"'rnu' is not a command", "Did you mean 'run'?"}},
      {"unknown_option", {"run", scenario, "--frobnicate"}, {"--frobnicate", "--help"}},
      {"mistyped_option",
       {"run", scenario, "--sceme", "tlm"},
       {"run: there is no option '--sceme'. Did you mean '--scheme'?"}},
      {"mistyped_option_with_its_value",
       {"control", "FOLDER", "force", "tip", "1,2,3", "--tmeout=3"},
       {"there is no option '--tmeout'. Did you mean '--timeout'?"}},
      {"run_of_a_flexible_side_alone",
       {"run", kExamples + "hinge/scenario.yaml"},
       {"mbs: is missing", "tandem fem " + kExamples + "hinge/scenario.yaml"}},
      {"run_without_scenario", {"run"}, {"SCENARIO is required", "--help"}},
      {"run_of_no_file", {"run", "nowhere.yaml"}, {"nowhere.yaml", "there is no such file"}},
      {"run_of_a_folder", {"run", "FOLDER"}, {"is a directory", "scenario.yaml"}},
      {"run_with_unknown_scheme",
       {"run", scenario, "--scheme", "gauss"},
       {"--scheme gauss: coupling.scheme: 'gauss' is not known",
        "explicit_serial, explicit_parallel, implicit, interface_jacobian, tlm"}},
      {"run_with_unknown_driver",
       {"run", scenario, "--driver", "hub"},
       {"'hub' is not known", "mbs, orchestrator"}},
      {"run_with_unknown_transport",
       {"run", scenario, "--transport", "tcp"},
       {"tcp", "lcm", "inproc"}},
      {"run_monolithic_attached",
       {"run", scenario, "--monolithic", "--attach"},
       {"--attach", "no side processes"}},
      {"run_monolithic_with_scheme",
       {"run", scenario, "--monolithic", "--scheme", "implicit"},
       {"--scheme", "Leave out --scheme or --monolithic"}},
      {"run_monolithic_over_lcm",
       {"run", scenario, "--transport", "lcm", "--monolithic"},
       {"--transport", "one process"}},
      {"set_without_value", {"check", scenario, "--set", "foo"}, {"--set foo", "key=value"}},
      {"set_of_unknown_key",
       {"check", scenario, "--set", "run.duration=1"},
       {"--set run.duration=1", "Did you mean 'duration_s' (s)?"}},
      {"set_of_wrong_value",
       {"check", scenario, "--set", "run.duration_s=abc"},
       {"'abc' is not a number", "Write a number"}},
      {"set_of_unknown_entry",
       {"check", scenario, "--set", "mbs.bodies.lefty.mass_kg=3"},
       {"mbs.bodies.lefty", "Did you mean 'left'?"}},
      {"compare_step_named_twice",
       {"compare", scenario, "--steps", "1e-3,5e-4,0.001"},
       {"--steps: 0.001 is named twice", "Name it once"}},
      {"compare_tolerance_named_twice",
       {"compare", scenario, "--steps", "1e-3", "--tolerances", "0.1,0.10"},
       {"--tolerances: 0.1 is named twice"}},
      {"adaptive_steps_beside_micro_steps",
       {"check", scenario, "--set", "coupling.adaptive.tolerance=0.1", "--set",
        "fem.micro_step_s=0.0005"},
       {"min_step_s", "no whole multiple of fem.micro_step_s"}},
      {"set_of_a_key_in_brackets",
       {"check", scenario, "--set", "mbs.bodies[0].mass=3"},
       {"mbs.bodies[0].mass=3", "Did you mean 'mass_kg' (kg)?"}},
      {"set_of_no_rotation",
       {"check", scenario, "--set", "mbs.bodies.0.orientation_wxyz=[0, 0, 0, 0]"},
       {"orientation_wxyz", "is all zeros"}},
      {"set_of_ages",
       {"check", scenario, "--set", "run.duration_s=1e300"},
       {"run.duration_s: 1e+300 s is out of range. It must be below 9.2e9 s"}},
      {"check_without_scenario", {"check"}, {"SCENARIO is required", "--help"}},
      {"compare_without_scenario", {"compare"}, {"SCENARIO is required", "--help"}},
      {"compare_never", {"compare", scenario, "--repeat", "0"}, {"--repeat", "1 to 1000"}},
      {"compare_steps_that_are_no_numbers",
       {"compare", scenario, "--steps", "1e-3,abc", "--out", "FOLDER"},
       {"--steps: 'abc' is not a number above 0"}},
      {"compare_steps_of_nothing",
       {"compare", scenario, "--steps", "1e-3,nan", "--out", "FOLDER"},
       {"--steps: 'nan' is not a number above 0"}},
      {"compare_tolerance_zero",
       {"compare", scenario, "--steps", "1e-3", "--tolerances", "0", "--out", "FOLDER"},
       {"--tolerances: '0' is not a number above 0"}},
      {"compare_half_a_time",
       {"compare", scenario, "--repeat", "1.5"},
       {"--repeat: '1.5' is not a whole number from 1 to 1000"}},
      {"advise_accuracy_too_fine",
       {"advise", scenario, "--accuracy", "1e-13"},
       {"--accuracy: '1e-13' is not a number from 1e-12 to 1"}},
      {"bench_of_no_nodes",
       {"bench", "exchange", "--nodes", "1,none"},
       {"--nodes: 'none' is not a whole number from 1 to 100000"}},
      {"control_without_patience",
       {"control", "FOLDER", "--timeout", "never", "release", "eye"},
       {"--timeout: 'never' is not a number above 0"}},
      {"compare_unknown_scheme",
       {"compare", scenario, "--schemes", "foo", "--out", "FOLDER"},
       {"--schemes foo: coupling.scheme: 'foo' is not known", "explicit_serial"}},
      {"bench_unknown", {"bench", "fme"}, {"'fme' is not a command", "Did you mean 'fem'?"}},
      {"replay_speed_of_a_side",
       {"replay", "FOLDER", "--side", "fem", "--speed", "2"},
       {"--speed requires --publish"}},
      {"replay_without_run", {"replay"}, {"RUN is required", "--help"}},
      {"replay_of_no_run",
       {"replay", scenario, "--side", "fem"},
       {"is not a run folder", "tandem run"}},
      {"replay_of_an_empty_folder",
       {"replay", "FOLDER", "--side", "fem"},
       {"scenario.yaml is missing"}},
      {"replay_unknown_side", {"replay", "FOLDER", "--side", "foo"}, {"scenario.yaml is missing"}},
      {"replay_negative_tolerance",
       {"replay", "FOLDER", "--side", "fem", "--tolerance", "-1"},
       {"--tolerance: '-1' is not a number of at least 0"}},
      {"log_without_run", {"log"}, {"RUN is required", "--help"}},
      {"log_of_no_run", {"log", "FOLDER"}, {"is not a complete run folder"}},
      {"report_of_no_run", {"report", "FOLDER"}, {"is not a complete run folder"}},
      {"keys_with_unknown_option", {"keys", "--foo"}, {"--foo", "--help"}},
  };
}

INSTANTIATE_TEST_SUITE_P(All, WrongCommandLine, testing::ValuesIn(lines()),
                         [](const auto& test) { return test.param.name; });

TEST(WrongCommandLines, ReplayWithoutSideAsksForOne) {
  const TemporaryFolder folder("tandem_line");
  const auto run = folder / "run";
  ASSERT_EQ(run_command(run_of("two_masses", run, {"--set", "run.duration_s=0.002"})).code, 0);
  for (const auto& more :
       std::vector<std::vector<std::string>>{{}, {"--side", "fem", "--publish"}}) {
    std::vector<std::string> arguments{"replay", run.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = tandem_command(arguments);
    EXPECT_EQ(ended.code, 2) << ended.output;
    EXPECT_NE(ended.output.find("choose one of --side SIDE and --publish"), std::string::npos)
        << ended.output;
  }
  const Ended again = run_command(run_of("two_masses", run));
  EXPECT_EQ(again.code, 2) << again.output;
  EXPECT_NE(again.output.find("already holds a run"), std::string::npos) << again.output;
}

// Commands on a run that has ended: nothing of it is written over, nothing is waited for.
TEST(WrongCommandLines, LeaveAnEndedRunAsItIs) {
  const TemporaryFolder folder("tandem_ended");
  const auto run = folder / "run";
  ASSERT_EQ(run_command(run_of("two_masses", run, {"--set", "run.duration_s=0.002"})).code, 0);
  const std::string scenario = read_file(run / "scenario.yaml");
  struct Refusal {
    std::vector<std::string> arguments;
    int code;
    std::string words;
  };
  std::vector<Refusal> refusals = {
      {{"replay", run.string(), "--publish", "--url", "nowhere"}, 2, "'nowhere' is no LCM URL"},
      {{"report", run.string(), "--out", "/proc/page.html"}, 2, "Choose another place"},
      {{"control", run.string(), "release", "left"}, 4, "it has ended"}};
  for (const std::string command : {"fem", "compare", "advise"}) {
    refusals.push_back({{command, kExamples + "two_masses/scenario.yaml", "--out", run.string()},
                        2,
                        "already holds results"});
  }
  for (const Refusal& refusal : refusals) {
    const Ended ended = tandem_command(refusal.arguments);
    EXPECT_EQ(ended.code, refusal.code) << ended.output;
    EXPECT_NE(ended.output.find(refusal.words), std::string::npos) << ended.output;
  }
  EXPECT_EQ(read_file(run / "scenario.yaml"), scenario);
}

// A name need not be text; what is said of it must still reach the user.
TEST(WrongCommandLines, AFileNameThatIsNoTextIsBadInput) {
  const TemporaryFolder folder("tandem_bytes");
  const std::string mesh = (folder / "\xff.msh").string();
  write_file(mesh, "no mesh");
  const Ended ended =
      run_command(run_of("two_masses", folder / "run", {"--set", "fem.mesh.file=" + mesh}));
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_NE(ended.output.find(mesh), std::string::npos) << ended.output;
  EXPECT_EQ(summary_of(folder / "run").value("status", ""), "failed");
}

TEST(WrongCommandLines, SidesStartedByHandSayWhatTheyNeed) {
  for (const char* name : {"/tandem-mbs", "/tandem-fem"}) {
    const std::string program = std::string(TANDEM_BIN_DIR) + name;
    const Ended nothing = run_command({program});
    EXPECT_EQ(nothing.code, 2) << nothing.output;
    EXPECT_NE(nothing.output.find("--scenario is required"), std::string::npos) << nothing.output;
    const std::string scenario = kExamples + "two_masses/scenario.yaml";
    const Ended run =
        run_command({program, "--scenario", scenario, "--run", "xyz", "--port", "20000"});
    EXPECT_EQ(run.code, 2) << run.output;
    EXPECT_NE(run.output.find("'xyz' is not a hexadecimal number"), std::string::npos)
        << run.output;
    const Ended port = run_command({program, "--scenario", scenario, "--run", "1", "--port", "80"});
    EXPECT_EQ(port.code, 2) << port.output;
    EXPECT_NE(port.output.find("1024"), std::string::npos) << port.output;
  }
}

}  // namespace
}  // namespace tandem::test
