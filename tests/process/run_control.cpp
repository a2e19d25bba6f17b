#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/support/tandem_process.h"

// Commands to a run that goes on: `tandem control` reaches the flexible body through the driver, is
// answered with the macro step, is in the log, and replays to the same bits.
namespace tandem::test {
namespace {

/// A run long enough for anything; ended by a signal.
std::vector<std::string> endless_run(const std::filesystem::path& folder,
                                     const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{
      "--set", "run.duration_s=10000", "--set", "run.macro_step_s=0.001", "--set", "fem.fixed=[]"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_of("pendulum_beam", folder, arguments);
}

/// Waits for the first recorded steps; false when they do not come.
bool stepping(const std::filesystem::path& folder) {
  for (int i = 0; i < 3000; ++i) {
    std::error_code error;
    if (std::filesystem::file_size(folder / "exchange.lcm", error) > 100'000 && !error) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

Ended control(const std::filesystem::path& folder, const std::vector<std::string>& command) {
  std::vector<std::string> arguments{"control", folder.string()};
  arguments.insert(arguments.end(), command.begin(), command.end());
  return tandem_command(arguments);
}

/// Waits until the log holds this text: the driver may be ahead of what is recorded, by more on a
/// lossy wire, and what is not recorded when a run is broken off is not in its log.
Ended recorded(const std::filesystem::path& folder, const std::string& text) {
  const std::vector<std::string> command{"log", folder.string()};
  Ended log = tandem_command(command);
  for (int i = 0; i < 500 && log.output.find(text) == std::string::npos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    log = tandem_command(command);
  }
  return log;
}

/// Gives back the summary of the run.
nlohmann::json command_and_replay(const std::vector<std::string>& more,
                                  const Environment& environment) {
  const TemporaryFolder folder;
  const auto out = folder / "run";
  ChildProcess run(endless_run(out, more), environment);
  EXPECT_TRUE(stepping(out)) << run.output();

  // Whoever reads the run's address may command it.
  constexpr auto kOthers = std::filesystem::perms::group_all | std::filesystem::perms::others_all;
  EXPECT_EQ(std::filesystem::status(out / "bus.json").permissions() & kOthers,
            std::filesystem::perms::none);
  const Ended force = control(out, {"force", "tip", "0,0.5,1.25"});
  EXPECT_EQ(force.code, 0) << force.output;
  EXPECT_NE(force.output.find("macro step "), std::string::npos) << force.output;
  const Ended fix = control(out, {"fix", "tip"});
  EXPECT_EQ(fix.code, 0) << fix.output;
  const Ended release = control(out, {"release", "tip"});
  EXPECT_EQ(release.code, 0) << release.output;

  const Ended wrong = control(out, {"release", "tipp"});
  EXPECT_EQ(wrong.code, 2) << wrong.output;
  EXPECT_NE(wrong.output.find("no node set 'tipp'"), std::string::npos) << wrong.output;
  EXPECT_EQ(control(out, {"release", "hub"}).code, 2);  // is a port
  EXPECT_EQ(control(out, {"melt", "tip"}).code, 2);
  const Ended half = control(out, {"force", "tip", "1,2"});
  EXPECT_EQ(half.code, 2);
  // In the order of the command line.
  EXPECT_NE(half.output.find("'force SET FX,FY,FZ'"), std::string::npos) << half.output;

  const Ended log = recorded(out, "force tip 1,2");
  EXPECT_NE(log.output.find("force tip 0,0.5,1.25"), std::string::npos) << log.output;
  EXPECT_NE(log.output.find("refused: "), std::string::npos) << log.output;
  run.signal(SIGINT);
  EXPECT_NE(run.wait(30.0), -1);
  const Ended late = control(out, {"release", "tip"});
  EXPECT_EQ(late.code, 4) << late.output;
  EXPECT_NE(late.output.find("no run answers"), std::string::npos) << late.output;

  const Ended csv = tandem_command({"log", out.string(), "--csv"});
  EXPECT_NE(csv.output.find(",command,1,0,0,0,\"force tip 0,0.5,1.25\","), std::string::npos);
  const Ended replay = tandem_command({"replay", out.string(), "--side", "fem"});
  EXPECT_EQ(replay.code, 0) << replay.output;
  return summary_of(out);
}

TEST(RunControl, CommandsAreMadeRecordedAndReplayed) { command_and_replay({}, {}); }

TEST(RunControl, AlsoWhenTheOrchestratorDrives) {
  command_and_replay({"--driver", "orchestrator"}, {});
}

TEST(RunControl, AlsoOnALossyWire) {
  const auto summary = command_and_replay(
      {}, with_preload({{"TANDEM_FAULT_DROP_PERCENT", "10"}, {"TANDEM_FAULT_SEED", "7"}},
                       TANDEM_FAULT_SHIM));
  EXPECT_GT(summary.at("wire").value("resent", 0), 0) << summary;
}

// What a thinned log leaves out are steps without a command.
TEST(RunControl, CommandsStayInAThinnedLog) {
  const TemporaryFolder folder;
  const auto out = folder / "run";
  ChildProcess run(endless_run(out, {"--set", "output.log_every_steps=50"}));
  EXPECT_TRUE(stepping(out)) << run.output();
  const std::vector<std::vector<std::string>> commands{
      {"force", "tip", "0,0.5,1.25"}, {"fix", "tip"}, {"release", "tip"}};
  for (const auto& command : commands) {
    const Ended made = control(out, command);
    EXPECT_EQ(made.code, 0) << made.output;
  }
  recorded(out, "release tip");
  run.signal(SIGINT);
  EXPECT_NE(run.wait(30.0), -1);
  const Ended csv = tandem_command({"log", out.string(), "--csv"});
  for (const char* text : {"\"force tip 0,0.5,1.25\"", "fix tip,", "release tip,"}) {
    EXPECT_NE(csv.output.find(std::string(",command,1,0,0,0,") + text), std::string::npos)
        << text << "\n"
        << csv.output.substr(0, 2000);
  }
  EXPECT_EQ(tandem_command({"replay", out.string(), "--side", "fem"}).code, 2);
}

// Changes of the scenario: both transports have the same bits, which are not those without changes.
TEST(RunControl, ChangesAfterTheEndAreRefused) {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& at_s) {
    return run_command(run_of("pendulum_beam", folder / at_s,
                              {"--set", "run.duration_s=0.03", "--transport", "inproc", "--set",
                               "fem.changes=[{at_s: " + at_s + ", fix: tip}]"}));
  };
  const Ended late = run("0.03");
  EXPECT_EQ(late.code, 2) << late.output;
  EXPECT_NE(late.output.find("fem.changes"), std::string::npos) << late.output;
  EXPECT_NE(late.output.find("would never be made"), std::string::npos) << late.output;
  EXPECT_FALSE(std::filesystem::exists(folder / "0.03"));
  EXPECT_EQ(run("0.028").code, 0);
}

TEST(RunControl, ScheduledChangesHaveTheSameBitsOverLcmAndInProcess) {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"--set", "run.duration_s=0.03"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = run_command(run_of("pendulum_beam", folder / name, arguments));
    EXPECT_EQ(ended.code, 0) << ended.output;
    return summary_of(folder / name).value("state_hash", "");
  };
  const std::string changes =
      "fem.changes=[{at_s: 0.005, fix: tip}, {at_s: 0.01, release: tip}, "
      "{at_s: 0.01, force: tip, force_N: [0.1, 0, 3]}]";
  const std::string lcm = run("lcm", {"--set", changes});
  EXPECT_EQ(run("inproc", {"--set", changes, "--transport", "inproc"}), lcm);
  EXPECT_NE(run("plain", {"--transport", "inproc"}), lcm);
  EXPECT_EQ(tandem_command({"replay", (folder / "lcm").string(), "--side", "fem"}).code, 0);
}

}  // namespace
}  // namespace tandem::test
