#include <gtest/gtest.h>
#include <lcm/lcm.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "protocol/wire/event_log.h"
#include "protocol/wire/multicast_socket.h"
#include "tests/support/tandem_process.h"

// exchange.lcm holds every exchange of a run, and either side can be driven from it alone.
namespace tandem::test {
namespace {

using wire::SideName;

/// What one log holds, event by event.
struct Contents {
  std::int64_t calls = 0, initializations = 0, accepted = 0, steps = 0;
  bool contiguous = true;
  bool ended = false;
};

Contents read_log(const std::filesystem::path& file) {
  wire::LogReader log(file);
  Contents contents;
  while (const auto journal = log.next_step()) {
    contents.contiguous &= journal->step.macro_step == contents.steps;
    ++contents.steps;
    std::int32_t iterations = 0;
    for (const wire::CallRecord& call : journal->calls) {
      ++contents.calls;
      contents.accepted += call.accepted ? 1 : 0;
      contents.contiguous &= call.macro_step == journal->step.macro_step;
      if (call.kind == wire::CallKind::Initialize) {
        ++contents.initializations;
      } else if (call.side == SideName::Mbs) {
        contents.contiguous &= call.iteration == ++iterations;
      } else {
        contents.contiguous &= call.iteration == iterations;
      }
    }
    contents.contiguous &= iterations == journal->step.iterations;
  }
  contents.ended = log.finished().has_value();
  return contents;
}

Environment five_percent() {
  return with_preload({{"TANDEM_FAULT_SEED", "5"},
                       {"TANDEM_FAULT_DROP_PERCENT", "5"},
                       {"TANDEM_FAULT_DUPLICATE_PERCENT", "5"},
                       {"TANDEM_FAULT_REORDER_PERCENT", "5"}},
                      TANDEM_FAULT_SHIM);
}

std::vector<std::string> short_run(const std::string& scheme) {
  return {"--scheme", scheme, "--set", "run.duration_s=0.02"};
}

struct LogCase {
  std::string example, scheme, driver;
};
std::string name_of(const testing::TestParamInfo<LogCase>& info) {
  return info.param.example + "_" + info.param.scheme + "_" + info.param.driver;
}
void PrintTo(const LogCase& c, std::ostream* out) { *out << c.example << " " << c.scheme; }

class RunLog : public testing::TestWithParam<LogCase> {};

TEST_P(RunLog, HoldsEveryExchangeOfALossyWireAndReplaysBothSides) {
  const TemporaryFolder folder("tandem_log");
  std::vector<std::string> arguments = short_run(GetParam().scheme);
  arguments.insert(arguments.end(), {"--driver", GetParam().driver});
  const auto run = folder / "run";
  const Ended ended = run_command(run_of(GetParam().example, run, arguments), five_percent());
  ASSERT_EQ(ended.code, 0) << ended.output;

  const auto summary = summary_of(run);
  const auto iterations = summary.at("iterations").at("total").get<std::int64_t>();
  const Contents contents = read_log(run / "exchange.lcm");
  EXPECT_EQ(contents.calls, 2 * iterations + 2);
  EXPECT_EQ(contents.initializations, 2);
  EXPECT_EQ(contents.accepted, 2 * 20 + 2);  // 20 macro steps and the initial values of both sides
  EXPECT_EQ(contents.steps, 21);
  EXPECT_TRUE(contents.contiguous);
  EXPECT_TRUE(contents.ended);

  const Ended told = tandem_command({"log", run.string()});
  EXPECT_EQ(told.code, 0);
  EXPECT_NE(told.output.find("calls        " + std::to_string(2 * iterations + 2) + " (" +
                             std::to_string(2 * iterations - 40) + " discarded"),
            std::string::npos)
      << told.output;

  for (const std::string side : {"fem", "mbs"}) {
    const Ended replay = tandem_command({"replay", run.string(), "--side", side});
    EXPECT_EQ(replay.code, 0) << replay.output;
    EXPECT_NE(replay.output.find("replay of " + side +
                                 " reproduces the log bit for bit: 20 macro steps, " +
                                 std::to_string(iterations + 1) + " calls (" +
                                 std::to_string(iterations - 20) + " discarded)"),
              std::string::npos)
        << replay.output;
  }
  EXPECT_TRUE(processes_with(folder.path().string()).empty());
}

INSTANTIATE_TEST_SUITE_P(Examples, RunLog,
                         testing::Values(LogCase{"lug", "interface_jacobian", "mbs"},
                                         LogCase{"two_masses", "implicit", "mbs"},
                                         LogCase{"two_masses", "explicit_serial", "orchestrator"},
                                         LogCase{"pendulum_beam", "implicit", "orchestrator"}),
                         name_of);

/// A finished implicit run of 10 macro steps, made once for all tests that damage copies of it.
class RunLogDamage : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>("tandem_damage");
    const Ended ended = run_command(
        run_of("two_masses", original(), {"--scheme", "implicit", "--set", "run.duration_s=0.01"}));
    ASSERT_EQ(ended.code, 0) << ended.output;
    find_events();
  }
  static void TearDownTestSuite() { folder_.reset(); }

  struct Event {
    std::size_t begin = 0, payload = 0, end = 0;
    std::string channel;
  };
  static std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value = (value << 8U) | static_cast<std::uint8_t>(bytes[at + i]);
    return value;
  }
  // LCM's event log: sync word, number (8), time (8), length of the channel, of the payload; both.
  static void find_events() {
    const std::string log = read_file(original() / "exchange.lcm");
    events_.clear();
    for (std::size_t at = 0; at < log.size(); at = events_.back().end) {
      const std::size_t channel = big_endian(log, at + 20);
      const std::size_t payload = at + 28 + channel;
      events_.push_back(
          {at, payload, payload + big_endian(log, at + 24), log.substr(at + 28, channel)});
    }
    ASSERT_TRUE(events_.back().channel.ends_with("_finished"));
  }
  /// The first call of macro step n: behind the step records of 0 … n − 1.
  static const Event& first_call_of(int macro_step) {
    int steps = 0;
    for (const Event& event : events_) {
      if (steps == macro_step) return event;
      steps += event.channel.ends_with("_step") ? 1 : 0;
    }
    throw std::logic_error("no such macro step");
  }

  static std::filesystem::path original() { return *folder_ / "run"; }
  std::filesystem::path copy() {
    const auto target = *folder_ / testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(target);
    std::filesystem::copy(original(), target, std::filesystem::copy_options::recursive);
    return target;
  }
  static Ended replay(const std::filesystem::path& run, const std::string& side = "fem") {
    return tandem_command({"replay", run.string(), "--side", side, "--transport", "inproc"});
  }
  /// Flips one byte of a copy: bad input, whatever reads it, and said with its place.
  void expect_noticed(std::size_t byte, const std::string& text, char mask = 0x10) {
    const auto run = copy();
    std::string log = read_file(run / "exchange.lcm");
    log[byte] = static_cast<char>(log[byte] ^ mask);
    write_file(run / "exchange.lcm", log);
    for (const std::string side : {"fem", "mbs"}) {
      const Ended ended = replay(run, side);
      EXPECT_EQ(ended.code, 2) << "byte " << byte << ", " << side << ": " << ended.output;
      EXPECT_NE(ended.output.find(text), std::string::npos)
          << "byte " << byte << ": " << ended.output;
    }
  }

  static std::unique_ptr<TemporaryFolder> folder_;
  static std::vector<Event> events_;
};
std::unique_ptr<TemporaryFolder> RunLogDamage::folder_;
std::vector<RunLogDamage::Event> RunLogDamage::events_;

TEST_F(RunLogDamage, AByteOfACallIsReportedAtItsMacroStep) {
  for (const int step : {1, 5, 10}) {
    const Event& call = first_call_of(step);
    const std::string text = "(in macro step " + std::to_string(step) + ")";
    expect_noticed((call.payload + call.end) / 2, text + ": its checksum is wrong");
    expect_noticed(call.end - 1, text);
  }
}

TEST_F(RunLogDamage, AByteOfAnEventHeaderIsReportedAtItsMacroStep) {
  const std::size_t begin = first_call_of(5).begin;
  expect_noticed(begin, "(in macro step 5): its sync word is wrong");
  expect_noticed(begin + 11, "(in macro step 5): its number is not the next one");
  expect_noticed(begin + 19, "(in macro step 5): its header does not fit its content");
  expect_noticed(begin + 28, "(in macro step 5): its header does not fit its content");
}

TEST_F(RunLogDamage, AByteOfALengthIsReportedAtItsMacroStep) {
  const std::size_t begin = first_call_of(5).begin;
  expect_noticed(begin + 23, "(in macro step 5)");                                      // channel
  expect_noticed(begin + 27, "(in macro step 5)");                                      // payload
  expect_noticed(begin + 24, "(in macro step 5): its lengths are out of range", 0x01);  // 16 MiB
}

TEST_F(RunLogDamage, AByteOfTheLastEventIsReportedBehindTheLastStep) {
  const Event& last = events_.back();
  expect_noticed(last.payload + 40, "its last one, behind macro step 10");
  expect_noticed(last.begin + 25, "ends behind macro step 10 without its last event");
  expect_noticed(events_.front().payload + 400, "event 0");
}

TEST_F(RunLogDamage, ACutLogOfAFinishedRunIsNotItsReplay) {
  const auto run = copy();
  std::filesystem::resize_file(run / "exchange.lcm", first_call_of(7).begin + 100);
  const Ended ended = replay(run);
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_NE(ended.output.find("ends behind macro step 6"), std::string::npos) << ended.output;
  EXPECT_NE(ended.output.find("done after 10 macro steps"), std::string::npos) << ended.output;
}

TEST_F(RunLogDamage, ALogWithoutAMacroStepReproducesNothing) {
  const auto run = copy();
  {
    wire::LogReader log(original() / "exchange.lcm");
    wire::LogWriter changed(run / "exchange.lcm", log.run_id(), log.scenario());
    changed.write(*log.next_step());  // the initialization
    changed.write(wire::Finished{.exit_code = 4, .message = "tandem-fem was killed"});
  }
  write_file(run / "summary.json", R"({"status": "failed"})");
  const Ended ended = replay(run);
  EXPECT_EQ(ended.code, 2) << ended.output;
  for (const char* words : {"holds no macro step", "tandem-fem was killed"}) {
    EXPECT_NE(ended.output.find(words), std::string::npos) << ended.output;
  }
  EXPECT_EQ(ended.output.find("reproduces"), std::string::npos) << ended.output;
}

TEST_F(RunLogDamage, AnEditedScenarioIsRefused) {
  const auto run = copy();
  std::string scenario = read_file(run / "scenario.yaml");
  const std::size_t at = scenario.find("young_Pa: ");
  ASSERT_NE(at, std::string::npos);
  scenario.insert(at + std::string("young_Pa: ").size(), "1");
  write_file(run / "scenario.yaml", scenario);
  const Ended ended = replay(run);
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_NE(ended.output.find("is not the scenario that"), std::string::npos) << ended.output;
  EXPECT_NE(ended.output.find("Restore it, or run anew"), std::string::npos) << ended.output;
}

TEST_F(RunLogDamage, TheLogOfAnotherMaterialIsRefused) {
  const auto run = copy();
  const auto other = *folder_ / "other";
  const Ended ended = run_command(run_of("two_masses", other,
                                         {"--scheme", "implicit", "--set", "run.duration_s=0.01",
                                          "--set", "fem.material.young_Pa=6e6"}));
  ASSERT_EQ(ended.code, 0) << ended.output;
  std::filesystem::copy_file(other / "exchange.lcm", run / "exchange.lcm",
                             std::filesystem::copy_options::overwrite_existing);
  const Ended replayed = replay(run);
  EXPECT_EQ(replayed.code, 2) << replayed.output;
  EXPECT_NE(replayed.output.find("is not the scenario that"), std::string::npos) << replayed.output;
}

// As a changed solver would: the last bit of one force in an otherwise perfect log.
TEST_F(RunLogDamage, OneBitOfAnOutputIsTheFirstDifference) {
  const auto run = copy();
  {
    wire::LogReader log(original() / "exchange.lcm");
    wire::LogWriter changed(run / "exchange.lcm", log.run_id(), log.scenario());
    while (auto journal = log.next_step()) {
      for (wire::CallRecord& call : journal->calls) {
        if (journal->step.macro_step != 7 || call.side != SideName::Fem) continue;
        double& f = call.wrenches.end[1].f_P_W.y();
        f = std::nextafter(f, HUGE_VAL);
      }
      changed.write(*journal);
    }
    changed.write(*log.finished());
  }
  const Ended replayed = replay(run);
  EXPECT_EQ(replayed.code, 5) << replayed.output;
  for (const char* words : {"fem: differs at macro step 7, ", "port 'right'", "f_y"}) {
    EXPECT_NE(replayed.output.find(words), std::string::npos) << words << ": " << replayed.output;
  }
}

TEST_F(RunLogDamage, AChangedMeshIsRefused) {
  const auto run = copy();
  const std::string mesh = read_file(kExamples + "two_masses/bar.msh");
  write_file(run / "bar.msh", mesh);
  // The resolved scenario names the mesh by its absolute path: the log must agree with it.
  const Ended ended = run_command(run_of(
      "two_masses", *folder_ / "own_mesh",
      {"--set", "run.duration_s=0.01", "--set", "fem.mesh.file=" + (run / "bar.msh").string()}));
  ASSERT_EQ(ended.code, 0) << ended.output;
  ASSERT_EQ(replay(*folder_ / "own_mesh").code, 0);
  write_file(run / "bar.msh", mesh + "\n");
  const Ended replayed = replay(*folder_ / "own_mesh");
  EXPECT_EQ(replayed.code, 2) << replayed.output;
  EXPECT_NE(replayed.output.find("the mesh is not the one this scenario was run with"),
            std::string::npos)
      << replayed.output;
}

TEST_F(RunLogDamage, AMissingMeshIsToldAsMissing) {
  const auto mesh = *folder_ / "gone.msh";
  std::filesystem::copy_file(kExamples + "two_masses/bar.msh", mesh);
  const auto run = *folder_ / "gone";
  const Ended ended = run_command(
      run_of("two_masses", run,
             {"--set", "run.duration_s=0.01", "--set", "fem.mesh.file=" + mesh.string()}));
  ASSERT_EQ(ended.code, 0) << ended.output;
  std::filesystem::remove(mesh);
  const Ended replayed = replay(run);
  EXPECT_EQ(replayed.code, 2) << replayed.output;
  EXPECT_NE(replayed.output.find("gone.msh"), std::string::npos) << replayed.output;
  EXPECT_EQ(replayed.output.find("checksum"), std::string::npos) << replayed.output;
}

TEST_F(RunLogDamage, ExportHasOneRowPerCall) {
  const auto csv = *folder_ / "export.csv";
  const Ended ended =
      run_command({"/bin/sh", "-c",
                   kTandem + " log --csv '" + original().string() + "' > '" + csv.string() + "'"});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const std::string text = read_file(csv);
  const auto iterations = summary_of(original()).at("iterations").at("total").get<std::int64_t>();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1 + 2 * iterations + 2);
  std::istringstream lines(text);
  std::string header, row;
  std::getline(lines, header);
  EXPECT_TRUE(header.starts_with(
      "macro_step,iteration,side,kind,accepted,rollback,outcome,H_s,command,t_s,"))
      << header;
  for (const char* table : {"steps.csv", "ports.csv"}) {
    const std::string rows = read_file(original() / table);
    // steps.csv: the header and 10 steps; ports.csv: also the initial values.
    EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), table[0] == 's' ? 11 : 12) << table;
  }
}

// The monolithic step has no line between the sides: its log is that of the sides alone.
TEST(RunLogExport, AMonolithicRunOfAScenarioWithALineReplays) {
  const TemporaryFolder folder("tandem_monolithic");
  const Ended run =
      run_command(run_of("two_masses", folder / "run",
                         {"--monolithic", "--set", "coupling.scheme=tlm", "--set",
                          "coupling.tlm.stiffness_N_per_m=1e6", "--set", "run.duration_s=0.01"}));
  ASSERT_EQ(run.code, 0) << run.output;
  for (const std::string side : {"mbs", "fem"}) {
    const Ended replay = tandem_command(
        {"replay", (folder / "run").string(), "--side", side, "--transport", "inproc"});
    EXPECT_EQ(replay.code, 0) << replay.output;
  }
}

TEST(RunLogExport, CheckShowsTheBodyBehindALine) {
  const Ended check =
      tandem_command({"check", kExamples + "two_masses/scenario.yaml", "--set",
                      "coupling.scheme=tlm", "--set", "coupling.tlm.stiffness_N_per_m=1e6"});
  ASSERT_EQ(check.code, 0) << check.output;
  EXPECT_NE(check.output.find("flexible body: "), std::string::npos) << check.output;
}

// An attempt that an adaptive step rejects ends where its own H leads to, and a command has a row.
TEST(RunLogExport, HasTheTimeOfEveryAttemptAndTheCommands) {
  const TemporaryFolder folder("tandem_export");
  const Ended run = run_command(run_of("slider_crank", folder / "run",
                                       {"--transport", "inproc", "--set", "run.duration_s=0.1",
                                        "--set", "coupling.adaptive.tolerance=1e-8"}));
  ASSERT_EQ(run.code, 0) << run.output;
  ASSERT_GT(summary_of(folder / "run").value("rejected_steps", 0), 0);
  const auto csv = folder / "export.csv";
  ASSERT_EQ(run_command({"/bin/sh", "-c",
                         kTandem + " log --csv '" + (folder / "run").string() + "' > '" +
                             csv.string() + "'"})
                .code,
            0);
  std::ifstream lines(csv);
  std::string line;
  std::getline(lines, line);
  const auto columns = std::count(line.begin(), line.end(), ',');
  double begin_s = 0.0;
  double end_s = 0.0;
  int last_step = 0;
  while (std::getline(lines, line)) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns);
    std::istringstream row(line);
    std::vector<std::string> cells;
    for (std::string cell; std::getline(row, cell, ',') && cells.size() < 10;) {
      cells.push_back(cell);
    }
    const int step = std::stoi(cells[0]);
    if (step != last_step) begin_s = std::exchange(end_s, 0.0);
    last_step = step;
    const double t_s = std::stod(cells[9]);
    EXPECT_NEAR(t_s, begin_s + std::stod(cells[7]), 1e-12) << line;  // both of whole nanoseconds
    if (cells[4] == "1") end_s = t_s;
  }
  EXPECT_NEAR(end_s, 0.1, 1e-12);
}

// liblcm's own tool publishes the log as it stands: every event, in order. Played slowly: one burst
// would overrun the default receive buffer.
TEST_F(RunLogDamage, IsPlayedByLcmLogplayer) {
  const std::string player = "/usr/bin/lcm-logplayer";
  if (!std::filesystem::exists(player)) GTEST_SKIP() << player << " is not installed";
  const std::string url = "udpm://239.255.76.67:" + std::to_string(wire::free_port()) + "?ttl=0";
  lcm_t* listener = lcm_create(url.c_str());
  ASSERT_NE(listener, nullptr);
  std::vector<std::string> heard;
  const auto handler = [](const lcm_recv_buf_t*, const char* channel, void* user) {
    static_cast<std::vector<std::string>*>(user)->emplace_back(channel);
  };
  lcm_subscription_t* all = lcm_subscribe(listener, "TANDEM_.*", handler, &heard);
  lcm_subscription_set_queue_capacity(all, 0);  // no limit
  ChildProcess process(
      {player, "--speed=0.05", "--lcm-url=" + url, (original() / "exchange.lcm").string()});
  // A call handles one message, or none within 100 ms. The player stretches the pauses of the run,
  // its start-up above all, by twenty: only a silence of forty seconds is the end.
  for (int idle = 0; idle < 400 && heard.size() < events_.size();) {
    idle = lcm_handle_timeout(listener, 100) > 0 ? 0 : idle + 1;
  }
  lcm_destroy(listener);
  EXPECT_EQ(process.wait(10.0), 0) << process.output();
  ASSERT_EQ(heard.size(), events_.size());
  for (std::size_t i = 0; i < heard.size(); ++i) EXPECT_EQ(heard[i], events_[i].channel);
}

}  // namespace
}  // namespace tandem::test
