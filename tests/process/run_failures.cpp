#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <thread>

#include "protocol/wire/multicast_socket.h"
#include "tests/support/tandem_process.h"

// Whichever process of a real run is killed, frozen or leaves early, in whichever phase: every
// survivor ends by itself in time, with exit code 4 and a text that names the process and the
// cause; nothing is left behind, and the log is readable. The fault shim ends the victim at a
// chosen datagram of its own, so that the phase is exact.
namespace tandem::test {
namespace {

constexpr double kTimeout_s = 1.0;       // wire.timeout_s
constexpr double kStartTimeout_s = 2.0;  // wire.start_timeout_s
constexpr double kDetection_s = 2.0;     // what the design allows beyond the time-out
// From the start of `tandem` to the fault: below a second on an idle machine; the rest is for one
// that is busy with other things.
constexpr double kStartUp_s = 10.0;
constexpr double kLimit_s = kStartUp_s + kStartTimeout_s + kDetection_s;
constexpr int kMacroSteps = 20;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A point of a process's part in the exchange: before the n-th datagram of this kind.
struct Phase {
  std::string name, kind;
  int count = 1;
};

/// explicit_serial: a side answers initialize, observe, one advance per macro step, observe, bye.
std::vector<Phase> phases_of(const std::string& victim, const std::string& driver) {
  constexpr int kLastAdvance = 2 + kMacroSteps;
  if (victim == "tandem") {
    if (driver == "mbs") {
      // One credit per entry of the journal: the initial values, the steps, the end. Before the
      // last credit tandem-fem has been dismissed already.
      return {{"start", "_alive", 2},
              {"mid", "_credit", 10},
              {"last", "_credit", kMacroSteps},
              {"end", "_credit", kMacroSteps + 2}};
    }
    return {{"start", "_alive", 2},
            {"handshake", "_hello"},
            {"mid", "_request", 20},
            {"last", "_request", 2 * kLastAdvance}};
  }
  if (victim == "tandem-mbs" && driver == "mbs") {
    return {{"start", "_selftest"},
            {"handshake", "_hello"},
            {"mid", "_request", 10},
            {"last", "_request", kLastAdvance},
            {"end", "_finished"}};
  }
  return {{"start", "_selftest"},
          {"handshake", "_welcome"},
          {"mid", "_reply", 10},
          {"last", "_reply", kLastAdvance},
          {"end", "_reply", kLastAdvance + 2}};
}

std::vector<std::string> settings(const std::string& driver) {
  return {"--driver", driver,
          "--set",    "coupling.scheme=explicit_serial",
          "--set",    "run.duration_s=" + std::to_string(1e-3 * kMacroSteps),
          "--set",    "wire.timeout_s=1",
          "--set",    "wire.start_timeout_s=2",
          "--set",    "wire.credit_window=1"};
}

/// One run with a fault, under way.
struct FaultyRun {
  Phase phase;
  std::unique_ptr<TemporaryFolder> folder = std::make_unique<TemporaryFolder>("tandem_failure");
  double begin_s = seconds_now();
  std::unique_ptr<ChildProcess> tandem;

  FaultyRun(const std::string& victim, const std::string& how, const std::string& driver, Phase p)
      : phase(std::move(p)),
        tandem(std::make_unique<ChildProcess>(
            run_of("two_masses", run(), settings(driver)),
            with_preload({{"TANDEM_FAULT_PROGRAM", victim},
                          {"TANDEM_FAULT_END", how},
                          {"TANDEM_FAULT_END_KIND", phase.kind},
                          {"TANDEM_FAULT_END_COUNT", std::to_string(phase.count)}},
                         TANDEM_FAULT_SHIM))) {}
  [[nodiscard]] std::filesystem::path run() const { return *folder / "run"; }
  [[nodiscard]] double rest_s() const {
    const bool starting = phase.name == "start" || phase.name == "handshake";
    const double timeout_s = starting ? kStartTimeout_s : kTimeout_s;
    return begin_s + kStartUp_s + timeout_s + kDetection_s - seconds_now();
  }
  [[nodiscard]] std::vector<pid_t> processes() const {
    return processes_with(folder->path().string());
  }
};

void expect_readable_log(const FaultyRun& run) {
  const Ended log = tandem_command({"log", run.run().string()});
  EXPECT_EQ(log.code, 0) << run.phase.name << ": " << log.output;
  if (run.phase.name != "mid") return;
  const Ended replay =
      tandem_command({"replay", run.run().string(), "--side", "fem", "--transport", "inproc"});
  EXPECT_EQ(replay.code, 0) << replay.output;
  EXPECT_NE(replay.output.find("reproduces the log bit for bit"), std::string::npos);
}

struct Case {
  std::string victim, how, driver;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.victim << " " << c.how; }
std::string name_of(const testing::TestParamInfo<Case>& info) {
  const std::string who =
      info.param.victim == "tandem" ? "orchestrator" : info.param.victim.substr(7);
  return who + "_" + (isdigit(info.param.how[0]) != 0 ? "exit" : "") + info.param.how + "_driver_" +
         info.param.driver;
}
std::vector<Case> cases(const std::vector<std::string>& victims) {
  std::vector<Case> all;
  for (const std::string& victim : victims) {
    for (const std::string how : {"kill", "stop", "0", "7"}) {
      for (const std::string driver : {"mbs", "orchestrator"}) all.push_back({victim, how, driver});
    }
  }
  return all;
}

class RunFailures : public testing::TestWithParam<Case> {
 protected:
  /// All phases at the same time: they mostly wait.
  static std::vector<FaultyRun> start_all() {
    const Case& c = GetParam();
    std::vector<FaultyRun> runs;
    for (const Phase& phase : phases_of(c.victim, c.driver)) {
      runs.emplace_back(c.victim, c.how, c.driver, phase);
    }
    return runs;
  }
};

class ASideFails : public RunFailures {};

TEST_P(ASideFails, TheRunEndsInTimeAndNamesItAndTheCause) {
  const std::map<std::string, std::string> causes{{"kill", "killed by signal 9"},
                                                  {"stop", "heard"},
                                                  {"0", "exit code 0"},
                                                  {"7", "exit code 7"}};
  for (FaultyRun& run : start_all()) {
    const int code = run.tandem->wait(run.rest_s());
    const std::string& output = run.tandem->output();
    // A side that leaves with 0 after its last answer has done its part, unless it is seen to leave
    // before it was told to.
    if (GetParam().how == "0" && run.phase.name == "end" && code == 0) continue;
    EXPECT_EQ(code, 4) << run.phase.name << ": " << output;
    EXPECT_NE(output.find(GetParam().victim), std::string::npos)
        << run.phase.name << ": " << output;
    EXPECT_NE(output.find(causes.at(GetParam().how)), std::string::npos)
        << run.phase.name << ": " << output;
    EXPECT_EQ(summary_of(run.run()).value("status", ""), "failed") << run.phase.name;
    EXPECT_TRUE(run.processes().empty()) << run.phase.name << ": a process was left behind";
    expect_readable_log(run);
  }
}

INSTANTIATE_TEST_SUITE_P(All, ASideFails, testing::ValuesIn(cases({"tandem-mbs", "tandem-fem"})),
                         name_of);

class TheOrchestratorFails : public RunFailures {
 protected:
  // Orphans become children of this process, so that their exit codes can be seen.
  void SetUp() override { ASSERT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 1), 0); }
  void TearDown() override { prctl(PR_SET_CHILD_SUBREAPER, 0); }

  /// Processes that still run, without those that have ended and wait for a frozen parent.
  static bool sides_run(const FaultyRun& run) {
    const auto running = run.processes();
    return std::any_of(running.begin(), running.end(), [](pid_t pid) {
      return read_file("/proc/" + std::to_string(pid) + "/comm").starts_with("tandem-");
    });
  }

  static void expect_named_in(const FaultyRun& run, const char* log) {
    const std::string text = read_file(run.run() / log);
    const bool named = text.find("tandem (the orchestrator)") != std::string::npos ||
                       text.find("the process that started it") != std::string::npos;
    EXPECT_TRUE(named) << run.phase.name << ", " << log << ": " << text;
  }
};

TEST_P(TheOrchestratorFails, BothSidesEndInTimeAndNameIt) {
  std::vector<FaultyRun> runs = start_all();
  for (FaultyRun& run : runs) {
    if (GetParam().how != "stop") {
      const int code = run.tandem->wait(run.rest_s());
      EXPECT_EQ(code, GetParam().how == "kill" ? 128 + SIGKILL : std::stoi(GetParam().how))
          << run.phase.name << ": " << run.tandem->output();
    }
    const auto launched = [&] {
      return std::filesystem::exists(run.run() / "mbs.log") &&
             std::filesystem::exists(run.run() / "fem.log");
    };
    // A process that has just been started bears its parent's name for a moment: look several
    // times.
    int quiet = 0;
    while (quiet < 20 && run.rest_s() > 0.0) {
      quiet = sides_run(run) || !launched() ? 0 : quiet + 1;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_EQ(quiet, 20) << run.phase.name << ": a side was left behind";
  }
  for (FaultyRun& run : runs) {
    run.tandem->signal(SIGKILL);
    run.tandem->wait(5.0);
  }
  int failed = 0;
  int dismissed = 0;
  for (int status = 0; waitpid(-1, &status, 0) > 0;) {
    EXPECT_TRUE(WIFEXITED(status)) << "status " << status;
    failed += WEXITSTATUS(status) == 4 ? 1 : 0;
    dismissed += WEXITSTATUS(status) == 0 ? 1 : 0;
  }
  const auto ends = std::count_if(runs.begin(), runs.end(),
                                  [](const FaultyRun& run) { return run.phase.name == "end"; });
  EXPECT_LE(dismissed, ends);
  EXPECT_EQ(failed + dismissed, 2 * static_cast<int>(runs.size()));
  for (const FaultyRun& run : runs) {
    expect_named_in(run, "mbs.log");
    if (run.phase.name != "end") expect_named_in(run, "fem.log");
    expect_readable_log(run);
  }
}

INSTANTIATE_TEST_SUITE_P(All, TheOrchestratorFails, testing::ValuesIn(cases({"tandem"})), name_of);

/// Programs of Tandem in a folder of their own, where single ones can be left out or replaced.
class RunWithStandIns : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder_ / "bin");
    for (const char* name : {"tandem", "tandem-mbs", "tandem-fem"}) {
      std::filesystem::copy_file(std::string(TANDEM_BIN_DIR "/") + name, folder_ / "bin" / name);
    }
  }
  void replace(const std::string& name, const std::string& script) {
    std::filesystem::remove(program(name));
    write_file(program(name), script);
    std::filesystem::permissions(program(name), std::filesystem::perms::owner_all);
  }
  [[nodiscard]] std::filesystem::path program(const std::string& name) const {
    return folder_ / "bin" / name;
  }
  /// A run by these programs must end in time with code 4 and these words.
  void expect_failure(const std::vector<std::string>& words, const std::string& driver = "mbs") {
    std::filesystem::remove_all(folder_ / "run");
    std::vector<std::string> command = run_of("two_masses", folder_ / "run", settings(driver));
    command[0] = program("tandem").string();
    const Ended ended = run_command(command, {{"PATH", "/nowhere"}}, kLimit_s);
    EXPECT_EQ(ended.code, 4) << ended.output;
    for (const std::string& word : words) {
      EXPECT_NE(ended.output.find(word), std::string::npos)
          << "no '" << word << "' in " << ended.output;
    }
    EXPECT_TRUE(processes_with(folder_.path().string()).empty());
  }

  TemporaryFolder folder_{"tandem_stand_in"};
};

TEST_F(RunWithStandIns, AMissingProgramIsNamedWithTheRemedy) {
  for (const std::string name : {"tandem-mbs", "tandem-fem"}) {
    const std::string content = read_file(program(name));
    std::filesystem::remove(program(name));
    expect_failure({"program '" + name + "' was found neither beside", "nor on PATH", "Build it"});
    write_file(program(name), content);
    std::filesystem::permissions(program(name), std::filesystem::perms::owner_all);
  }
}

TEST_F(RunWithStandIns, AProgramThatIsNotExecutableIsNamed) {
  std::filesystem::permissions(program("tandem-fem"), std::filesystem::perms::owner_read);
  expect_failure({"cannot start '" + program("tandem-fem").string() + "'", "Permission denied"});
}

TEST_F(RunWithStandIns, AnEarlyExitIsNamedWithItsCode) {
  for (const std::string driver : {"mbs", "orchestrator"}) {
    replace("tandem-fem", "#!/bin/sh\nexit 0\n");
    expect_failure({"tandem-fem ended with exit code 0 before the run was over"}, driver);
    replace("tandem-fem", "#!/bin/sh\necho no licence; exit 1\n");
    expect_failure({"tandem-fem ended: exit code 1", "fem.log"}, driver);
  }
  EXPECT_EQ(read_file(folder_ / "run/fem.log"), "no licence\n");
}

TEST_F(RunWithStandIns, AProgramThatNeverJoinsIsNamed) {
  replace("tandem-mbs", "#!/bin/sh\nexec /bin/sleep 60\n");
  expect_failure({"tandem-mbs has not been heard within 2 s"});
}

// The other two are absent, as when a user starts one process by hand and forgets the rest.
TEST(RunFailuresAlone, ASideWithoutPartnersEndsInTime) {
  const TemporaryFolder folder("tandem_alone");
  ASSERT_EQ(run_command(run_of("two_masses", folder / "run", settings("mbs"))).code, 0);
  const std::map<std::string, std::string> partner{{"tandem-mbs", "tandem-fem"},
                                                   {"tandem-fem", "tandem-mbs"}};
  for (const auto& [name, missing] : partner) {
    const double begin_s = seconds_now();
    const Ended ended =
        run_command({std::string(TANDEM_BIN_DIR "/") + name, "--scenario",
                     (folder / "run/scenario.yaml").string(), "--run", "00000000000000aa", "--port",
                     std::to_string(wire::free_port())},
                    {}, kLimit_s);
    EXPECT_EQ(ended.code, 4) << ended.output;
    EXPECT_NE(ended.output.find(missing + " has not been heard within 2 s: it was not started"),
              std::string::npos)
        << ended.output;
    EXPECT_LT(seconds_now() - begin_s, kLimit_s);
  }
}

// A frozen side cannot notice that the orchestrator has died: the kernel wakes it.
TEST(RunFailuresAlone, AFrozenSideDoesNotOutliveTheOrchestrator) {
  const TemporaryFolder folder("tandem_frozen");
  ChildProcess tandem(run_of("two_masses", folder / "run",
                             {"--set", "run.duration_s=1000", "--set", "wire.timeout_s=60"}));
  const double end_s = seconds_now() + kLimit_s;
  const auto steps = folder / "run/exchange.lcm";
  while ((!std::filesystem::exists(steps) || std::filesystem::file_size(steps) < 50000) &&
         seconds_now() < end_s) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const std::string folder_name = folder.path().string();
  for (pid_t pid : processes_with(folder_name)) {
    if (read_file("/proc/" + std::to_string(pid) + "/comm") == "tandem-fem\n") kill(pid, SIGSTOP);
  }
  tandem.signal(SIGKILL);
  EXPECT_EQ(tandem.wait(2.0), 128 + SIGKILL);
  while (!processes_with(folder_name).empty() && seconds_now() < end_s) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_TRUE(processes_with(folder_name).empty());
  EXPECT_NE(read_file(folder / "run/fem.log").find("the process that started it"),
            std::string::npos);
}

}  // namespace
}  // namespace tandem::test
