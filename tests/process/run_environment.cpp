#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <memory>
#include <thread>

#include "protocol/wire/multicast_socket.h"
#include "tests/support/tandem_process.h"

// What surrounds a run: a user who interrupts it, disks that are full or read-only, a host without
// multicast, closed streams, odd folder names, another run at the same time.
namespace tandem::test {
namespace {

constexpr double kLimit_s = 10.0;  // all of these end at once; the rest is for a busy machine

bool has(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

/// `tandem run two_masses` as words of a shell command.
std::string shell_run(const std::filesystem::path& folder, const std::string& more = "") {
  return kTandem + " run " + kExamples + "two_masses/scenario.yaml --quiet --out '" +
         folder.string() + "' " + more;
}
Ended shell(const std::string& command) {
  return run_command({"/bin/sh", "-c", command}, {}, 60.0);
}

struct Interruption {
  std::string name;
  int signal = 0;
  bool whole_group = false;
  std::vector<std::string> more;
  bool waiting = false;  ///< of a run whose first macro step is due much later
};
void PrintTo(const Interruption& i, std::ostream* out) { *out << i.name; }

class Interrupted : public testing::TestWithParam<Interruption> {};

TEST_P(Interrupted, EndsInOrderWithTheSignalsExitCode) {
  const Interruption& test = GetParam();
  signal(test.signal, SIG_DFL);  // what a background job ignores, its children ignore
  const TemporaryFolder folder("tandem_interrupted");
  const auto run = folder / "run";
  std::vector<std::string> command = run_of("two_masses", run, {"--set", "run.duration_s=1000"});
  command.insert(command.end(), test.more.begin(), test.more.end());
  command.insert(command.begin(), "/usr/bin/setsid");  // a process group of its own, same pid
  ChildProcess tandem(command);
  const auto log = run / "exchange.lcm";
  // A run that waits has logged the start and the first macro step, and logs no more.
  const auto far_enough = [&] {
    const std::string logged = read_file(log);
    const std::string step = "_orchestrator_step";
    const auto first = logged.find(step);
    return test.waiting
               ? first != std::string::npos && logged.find(step, first + 1) != std::string::npos
               : logged.size() > 50000;
  };
  for (int i = 0; i < 2000 && !far_enough(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  kill(test.whole_group ? -tandem.pid() : tandem.pid(), test.signal);
  EXPECT_EQ(tandem.wait(kLimit_s), 128 + test.signal) << tandem.output();
  EXPECT_TRUE(has(tandem.output(), "interrupted by SIG")) << tandem.output();
  EXPECT_TRUE(processes_with(folder.path().string()).empty());

  const auto summary = summary_of(run);
  EXPECT_EQ(summary.value("status", ""), "interrupted");
  const auto steps = summary.value("macro_steps", 0);
  EXPECT_GT(steps, 0);
  // Everything that the recorded steps tell: two_masses has macro steps of 1 ms.
  EXPECT_DOUBLE_EQ(summary.value("simulated_s", 0.0), 1e-3 * steps);
  EXPECT_GE(summary.at("iterations").value("total", 0), steps);
  double ledger_s = 0.0;
  for (const auto& [part, seconds] : summary.at("ledger_s").items()) {
    if (part != "discarded") ledger_s += (part == "overlap" ? -1.0 : 1.0) * seconds.get<double>();
  }
  EXPECT_GT(ledger_s, 0.0);
  EXPECT_NEAR(ledger_s, summary.value("wall_s", 0.0), 0.02 * ledger_s);
  EXPECT_EQ(summary.at("ports").size(), 2U);
  EXPECT_FALSE(summary.contains("state_hash"));

  const Ended described = tandem_command({"log", run.string()});
  EXPECT_TRUE(has(described.output, "macro steps  " + std::to_string(steps) + "\n"))
      << described.output;
  EXPECT_TRUE(has(described.output, "behind macro step " + std::to_string(steps) +
                                        " with exit code " + std::to_string(128 + test.signal) +
                                        ": interrupted by SIG"))
      << described.output;
  // steps.csv: the header and a whole row per step.
  const std::string rows = read_file(run / "steps.csv");
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), steps + 1);
  EXPECT_EQ(rows.back(), '\n');
}

INSTANTIATE_TEST_SUITE_P(
    All, Interrupted,
    testing::Values(Interruption{"int_alone", SIGINT, false, {}},
                    Interruption{"int_group", SIGINT, true, {}},
                    Interruption{"term_alone", SIGTERM, false, {}},
                    Interruption{"term_group", SIGTERM, true, {}},
                    Interruption{"hangup", SIGHUP, true, {}},
                    Interruption{"int_hub", SIGINT, true, {"--driver", "orchestrator"}},
                    Interruption{"term_hub", SIGTERM, false, {"--driver", "orchestrator"}},
                    Interruption{"int_inproc", SIGINT, false, {"--transport", "inproc"}},
                    Interruption{"term_monolithic", SIGTERM, false, {"--monolithic"}},
                    Interruption{"int_waiting", SIGINT, false, {"--set", "run.pace=1e-5"}, true},
                    Interruption{"term_waiting_hub",
                                 SIGTERM,
                                 false,
                                 {"--driver", "orchestrator", "--set", "run.pace=1e-5"},
                                 true},
                    Interruption{"term_waiting_inproc",
                                 SIGTERM,
                                 false,
                                 {"--transport", "inproc", "--set", "run.pace=1e-5"},
                                 true}),
    [](const auto& test) { return test.param.name; });

// RLIMIT_FSIZE: writing fails in the middle of a file, as on a full disk, without any privilege.
TEST(RunEnvironment, AFullDiskEndsTheRunAndNamesTheFile) {
  const TemporaryFolder folder("tandem_full");
  for (const std::string mode : {"--transport lcm", "--transport inproc"}) {
    const auto run = folder / ("run" + mode.substr(12));
    // The multibody process may be ahead of the recorder: it shall not fill a file of its own
    // first.
    const Ended ended = shell("trap '' XFSZ; ulimit -f 64; exec " +
                              shell_run(run, mode + " --set output.bodies_every_steps=0"));
    EXPECT_EQ(ended.code, 4) << ended.output;
    EXPECT_TRUE(has(ended.output, "cannot write " + (run / "exchange.lcm").string()))
        << ended.output;
    EXPECT_TRUE(has(ended.output, "Free some space or choose another --out")) << ended.output;
    const auto steps = summary_of(run).value("macro_steps", 0);
    EXPECT_GT(steps, 0);
    const Ended log = tandem_command({"log", run.string()});
    EXPECT_TRUE(has(log.output, "macro steps  " + std::to_string(steps) + "\n")) << log.output;
  }
  EXPECT_TRUE(processes_with(folder.path().string()).empty());
}

class FullFile : public testing::TestWithParam<std::string> {};

TEST_P(FullFile, IsNamed) {
  const TemporaryFolder folder("tandem_full_file");
  const auto run = folder / "run";
  std::filesystem::create_directory(run);
  std::filesystem::create_symlink("/dev/full", run / GetParam());
  const Ended ended = run_command(run_of("two_masses", run));
  EXPECT_EQ(ended.code, 4) << ended.output;
  EXPECT_TRUE(has(ended.output, "cannot write ")) << ended.output;
  EXPECT_TRUE(has(ended.output, (run / GetParam()).string())) << ended.output;
  EXPECT_TRUE(has(ended.output, "No space left on device")) << ended.output;
  EXPECT_TRUE(processes_with(folder.path().string()).empty());
}

INSTANTIATE_TEST_SUITE_P(Files, FullFile,
                         testing::Values("steps.csv", "ports.csv", "bodies.csv", "summary.json"),
                         [](const auto& test) {
                           return test.param.substr(0, test.param.find('.'));
                         });

TEST(RunEnvironment, AFullFileSystemLeavesAReadableLog) {
  const TemporaryFolder folder("tandem_tmpfs");
  const std::string mount = "mount -t tmpfs -o size=300k none '" + folder.path().string() + "'";
  if (shell("unshare -m sh -c \"" + mount + "\"").code != 0) {
    GTEST_SKIP() << "mount namespaces are not permitted here";
  }
  const std::string run = shell_run(folder / "run");
  const std::string log = kTandem + " log '" + (folder / "run").string() + "'";
  // There is a whole summary, or none: never an empty one.
  const std::string summary = "'" + (folder / "run/summary.json").string() + "'";
  const std::string whole = "(test ! -e " + summary + " || grep -q '^}' " + summary + ")";
  const Ended ended =
      shell("unshare -m sh -c \"" + mount + "; " + run + "; " + log + " && " + whole + "\"");
  EXPECT_EQ(ended.code, 0) << ended.output;  // of `tandem log` and of the summary's test
  EXPECT_TRUE(has(ended.output, "No space left on device")) << ended.output;
  EXPECT_TRUE(has(ended.output, "without its last event")) << ended.output;
}

TEST(RunEnvironment, AReadOnlyFolderIsNamedWithTheRemedy) {
  const TemporaryFolder folder("tandem_read_only");
  const std::string mount = "mount -t tmpfs -o ro none '" + folder.path().string() + "'";
  if (shell("unshare -m sh -c \"" + mount + "\"").code != 0) {
    GTEST_SKIP() << "mount namespaces are not permitted here";
  }
  const Ended ended =
      shell("unshare -m sh -c \"" + mount + "; exec " + shell_run(folder / "run") + "\"");
  EXPECT_EQ(ended.code, 4) << ended.output;
  EXPECT_TRUE(has(ended.output, "cannot create the run folder")) << ended.output;
  EXPECT_TRUE(has(ended.output, "Read-only file system. Choose another with --out"))
      << ended.output;
}

TEST(RunEnvironment, APlaceWhereNoFolderCanBeIsNamed) {
  const TemporaryFolder folder("tandem_no_folder");
  write_file(folder / "file", "");
  for (const std::filesystem::path& path : {folder / "file/run", std::filesystem::path("/proc/run"),
                                            std::filesystem::path("/dev/null")}) {
    const Ended ended = run_command(run_of("two_masses", path));
    EXPECT_EQ(ended.code, 2) << ended.output;
    EXPECT_TRUE(has(ended.output, "cannot create the run folder")) << ended.output;
    EXPECT_TRUE(has(ended.output, "Choose another with --out")) << ended.output;
  }
}

TEST(RunEnvironment, AFolderNameThatIsTooLongIsNamed) {
  const TemporaryFolder folder("tandem_long_name");
  const Ended ended = run_command(run_of("two_masses", folder / std::string(300, 'x')));
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_TRUE(has(ended.output, "File name too long. Choose another with --out")) << ended.output;
}

TEST(RunEnvironment, AHostWithoutMulticastRouteIsToldTheRemedy) {
  const TemporaryFolder folder("tandem_no_route");
  if (shell("unshare -n true").code != 0) {
    GTEST_SKIP() << "network namespaces are not permitted here";
  }
  const auto begin = std::chrono::steady_clock::now();
  const Ended ended = shell("exec unshare -n " + shell_run(folder / "run"));
  EXPECT_EQ(ended.code, 4) << ended.output;
  EXPECT_TRUE(has(ended.output, "no route to the multicast group")) << ended.output;
  EXPECT_TRUE(has(ended.output, "ip route add 224.0.0.0/4 dev lo")) << ended.output;
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
}

TEST(RunEnvironment, AFilteredMulticastIsToldTheRemedy) {
  const TemporaryFolder folder("tandem_filter");
  const Ended ended = run_command(
      run_of("two_masses", folder / "run"),
      with_preload({{"TANDEM_FAULT_DROP_PERCENT", "100"}}, TANDEM_FAULT_SHIM), kLimit_s);
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_TRUE(has(ended.output, "A firewall filters multicast")) << ended.output;
}

TEST(RunEnvironment, APortThatAnotherProgramHoldsIsNamed) {
  const TemporaryFolder folder("tandem_port");
  ASSERT_EQ(
      run_command(run_of("two_masses", folder / "run", {"--set", "run.duration_s=0.002"})).code, 0);
  const int port = wire::free_port();
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  const Ended ended = run_command(
      {TANDEM_BIN_DIR "/tandem-fem", "--scenario", (folder / "run/scenario.yaml").string(), "--run",
       "00000000000000aa", "--port", std::to_string(port)},
      {}, kLimit_s);
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_TRUE(has(ended.output, "another program holds the port")) << ended.output;
  close(fd);
}

TEST(RunEnvironment, TwoRunsAtTheSameTimeDoNotDisturbEachOther) {
  const TemporaryFolder folder("tandem two runs: ä 'quoted'");
  const std::vector<std::string> duration{"--set", "run.duration_s=0.1"};
  ChildProcess a(run_of("two_masses", folder / "a", duration));
  ChildProcess b(run_of("two_masses", folder / "b", duration));
  EXPECT_EQ(a.wait(60.0), 0) << a.output();
  EXPECT_EQ(b.wait(60.0), 0) << b.output();
  ASSERT_EQ(run_command(run_of("two_masses", folder / "c",
                               {"--set", "run.duration_s=0.1", "--transport", "inproc"}))
                .code,
            0);
  const std::string hash = summary_of(folder / "c").at("state_hash").get<std::string>();
  EXPECT_EQ(summary_of(folder / "a").at("state_hash").get<std::string>(), hash);
  EXPECT_EQ(summary_of(folder / "b").at("state_hash").get<std::string>(), hash);
  // The folder's name has spaces and quotes: the run can also be replayed from there.
  EXPECT_EQ(tandem_command({"replay", (folder / "a").string(), "--side", "mbs"}).code, 0);
}

TEST(RunEnvironment, ReplaysStartedTogetherDoNotDisturbEachOther) {
  const TemporaryFolder folder("tandem_replays");
  ASSERT_EQ(run_command(run_of("two_masses", folder / "run", {"--set", "run.duration_s=0.2"})).code,
            0);
  std::vector<std::unique_ptr<ChildProcess>> replays;
  const std::vector<std::string> command{kTandem, "replay", (folder / "run").string(), "--side",
                                         "mbs"};
  for (int i = 0; i < 3; ++i) replays.push_back(std::make_unique<ChildProcess>(command));
  int done = 0;
  for (const auto& replay : replays) {
    const int code = replay->wait(60.0);
    done += code == 0 ? 1 : 0;
    EXPECT_TRUE(code == 0 || has(replay->output(), "another command writes into this folder"))
        << code << ": " << replay->output();
  }
  EXPECT_GT(done, 0);
}

// A file opened next would take the number of a closed stream, and messages would go into it.
TEST(RunEnvironment, ClosedStandardStreamsHarmNoFile) {
  const TemporaryFolder folder("tandem_closed");
  const std::string duration = "--set run.duration_s=0.01";
  EXPECT_EQ(shell("exec " + shell_run(folder / "run", duration) + " <&- >&- 2>&-").code, 0);
  EXPECT_EQ(tandem_command({"replay", (folder / "run").string(), "--side", "fem"}).code, 0);
  EXPECT_EQ(shell("exec " + shell_run(folder / "full", duration) + " > /dev/full").code, 0);
  const Ended log = shell(kTandem + " log --csv '" + (folder / "run").string() + "' > /dev/full");
  EXPECT_EQ(log.code, 4) << log.output;
  EXPECT_TRUE(has(log.output, "cannot write the export: No space left on device")) << log.output;
}

/// Waits until a run has written so many bytes of its log.
void await_steps(const std::filesystem::path& run) {
  for (int i = 0; i < 3000; ++i) {
    std::error_code error;
    if (std::filesystem::file_size(run / "exchange.lcm", error) > 100'000 && !error) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

TEST(RunEnvironment, AFolderThatIsRemovedInMidRunIsNoticedAtOnce) {
  for (const std::string transport : {"lcm", "inproc"}) {
    const TemporaryFolder folder("tandem_removed");
    ChildProcess tandem(run_of("two_masses", folder / "run",
                               {"--set", "run.duration_s=1000", "--transport", transport}));
    await_steps(folder / "run");
    std::filesystem::remove_all(folder / "run");
    EXPECT_EQ(tandem.wait(kLimit_s), 4) << tandem.output();
    EXPECT_TRUE(has(tandem.output(), "exchange.lcm was removed while it was written"))
        << tandem.output();
    EXPECT_TRUE(processes_with(folder.path().string()).empty());
  }
}

// A side that is frozen or outlives its run would keep the log's space and the port taken.
TEST(RunEnvironment, SidesHaveNoFileOfTheProcessThatStartedThem) {
  const TemporaryFolder folder("tandem_descriptors");
  ChildProcess tandem(run_of("two_masses", folder / "run", {"--set", "run.duration_s=1000"}));
  await_steps(folder / "run");
  int sides = 0;
  for (const pid_t pid : processes_with(folder.path().string())) {
    if (pid == tandem.pid()) continue;
    ++sides;
    for (const auto& entry :
         std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/fd")) {
      std::error_code error;
      const auto file = std::filesystem::read_symlink(entry.path(), error).filename();
      EXPECT_TRUE(file != "exchange.lcm" && file != "steps.csv" && file != "ports.csv") << file;
    }
  }
  EXPECT_EQ(sides, 2);
}

// Its sides give it up and end; continued, it finds them gone, and has forwarded nothing.
TEST(RunEnvironment, AQuietTandemThatWasFrozenSaysTheCause) {
  const TemporaryFolder folder("tandem_frozen");
  ChildProcess tandem(run_of("two_masses", folder / "run",
                             {"--set", "run.duration_s=1000", "--set", "wire.timeout_s=0.5"}));
  await_steps(folder / "run");
  tandem.signal(SIGSTOP);
  for (int i = 0; i < 3000 && processes_with(folder.path().string()).size() > 1; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  tandem.signal(SIGCONT);
  EXPECT_EQ(tandem.wait(kLimit_s), 4) << tandem.output();
  EXPECT_TRUE(has(tandem.output(), "nothing heard from tandem (the orchestrator) for 0.5 s"))
      << tandem.output();
}

TEST(RunEnvironment, AMeshThatIsNoFileIsRefusedAtItsPlace) {
  const TemporaryFolder folder("tandem_pipe_mesh");
  ASSERT_EQ(mkfifo((folder / "pipe.msh").c_str(), 0600), 0);
  std::filesystem::create_directory(folder / "folder.msh");
  const std::string scenario = kExamples + "pendulum_beam/scenario.yaml";
  for (const auto& [file, words] : std::vector<std::pair<std::string, std::string>>{
           {(folder / "pipe.msh").string(), "a pipe or device, not a file"},
           {(folder / "folder.msh").string(), "a folder, not a file"},
           {"/dev/zero", "a pipe or device, not a file"},
           {(folder / "none.msh").string(), "cannot be read: No such file or directory"}}) {
    for (const std::string command : {"check", "run", "fem"}) {
      const Ended ended =
          run_command({kTandem, command, scenario, "--set", "fem.mesh.file=" + file}, {}, kLimit_s);
      EXPECT_EQ(ended.code, 2) << command << " " << file << ": " << ended.output;
      EXPECT_TRUE(has(ended.output, "fem.mesh.file: '" + file + "' ")) << ended.output;
      EXPECT_TRUE(has(ended.output, words)) << ended.output;
    }
    // Of a nodal coupling the mesh makes the ports and the bodies: it is read before all else.
    const Ended nodal = run_command(
        {kTandem, "run", kExamples + "bar15/scenario.yaml", "--set", "fem.mesh.file=" + file}, {},
        kLimit_s);
    EXPECT_EQ(nodal.code, 2) << nodal.output;
    EXPECT_TRUE(has(nodal.output, words)) << nodal.output;
  }
}

TEST(RunEnvironment, AReaderThatLeavesDoesNotEndTheRun) {
  const TemporaryFolder folder("tandem_pipe");
  const std::string run = kTandem + " run " + kExamples + "two_masses/scenario.yaml --out '" +
                          (folder / "run").string() + "' --set run.duration_s=0.1";
  shell("(" + run + ") 2>&1 | true");
  EXPECT_EQ(summary_of(folder / "run").value("status", ""), "done");
}

// However the sides wait for each other, on as many cores as there are and on one, where a side
// that polls would keep the other from computing.
TEST(RunEnvironment, WaysOfWaitingHaveTheSameBits) {
  const TemporaryFolder folder("tandem_wait");
  const auto hash = [&](const std::string& name, const std::vector<std::string>& before,
                        const std::vector<std::string>& more) {
    std::vector<std::string> command = before;
    std::vector<std::string> options{"--set", "run.duration_s=0.05"};
    options.insert(options.end(), more.begin(), more.end());
    const std::vector<std::string> run = run_of("two_masses", folder / name, options);
    command.insert(command.end(), run.begin(), run.end());
    const Ended ended = run_command(command, {}, kLimit_s);
    EXPECT_EQ(ended.code, 0) << name << ": " << ended.output;
    return summary_of(folder / name).value("state_hash", "");
  };
  const std::string inproc = hash("inproc", {}, {"--transport", "inproc"});
  for (const std::string wait : {"block", "adaptive", "poll"}) {
    const std::vector<std::string> waiting{"--set", "wire.wait=" + wait};
    EXPECT_EQ(hash(wait, {}, waiting), inproc);
    EXPECT_EQ(hash(wait + "_one_core", {"/usr/bin/taskset", "-c", "0"}, waiting), inproc);
  }
}

}  // namespace
}  // namespace tandem::test
