#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "tests/support/tandem_process.h"

// `tandem trace` on runs as they are made: the file is what viewers read, its arrows go forward in
// time, and the shares of the critical path are those of the whole.
namespace tandem::test {
namespace {

using nlohmann::json;

json trace_of(const std::filesystem::path& run, const std::vector<std::string>& more = {}) {
  std::vector<std::string> command{"trace", run.string()};
  command.insert(command.end(), more.begin(), more.end());
  const Ended ended = tandem_command(command);
  EXPECT_EQ(ended.code, 0) << ended.output;
  EXPECT_NE(ended.output.find("what to speed up first"), std::string::npos) << ended.output;
  json trace = json::parse(read_file(run / "trace.json"), nullptr, false);
  EXPECT_FALSE(trace.is_discarded());
  return trace;
}

std::set<std::string> processes_of(const json& trace) {
  std::set<std::string> names;
  for (const json& event : trace.at("traceEvents")) {
    if (event.at("name") == "process_name") names.insert(event["args"]["name"]);
  }
  return names;
}

/// Number of arrows; each has one begin and, not before it, one end, in another process.
std::size_t expect_forward_arrows(const json& trace) {
  std::map<std::int64_t, json> begins;
  std::size_t ends = 0;
  for (const json& event : trace.at("traceEvents")) {
    if (event.at("ph") == "s") begins[event["id"]] = event;
    if (event.at("ph") != "f") continue;
    ++ends;
    const auto begin = begins.find(event["id"]);
    if (begin == begins.end()) {
      ADD_FAILURE() << event;
      continue;
    }
    EXPECT_GE(event["ts"].get<double>(), begin->second["ts"].get<double>()) << event;
    EXPECT_NE(event["pid"], begin->second["pid"]);
  }
  EXPECT_EQ(ends, begins.size());
  return ends;
}

/// Slices of one track lie in each other or apart, as viewers need them.
void expect_nested_slices(const json& trace) {
  std::map<std::pair<int, int>, std::vector<std::pair<double, double>>> tracks;
  for (const json& event : trace.at("traceEvents")) {
    if (event.at("ph") != "X") continue;
    const double begin = event["ts"];
    EXPECT_GE(event["dur"].get<double>(), 0.0);
    tracks[{event["pid"], event["tid"]}].emplace_back(begin, begin + event["dur"].get<double>());
  }
  for (auto& [track, slices] : tracks) {
    std::sort(slices.begin(), slices.end(), [](const auto& a, const auto& b) {
      return a.first != b.first ? a.first < b.first : a.second > b.second;
    });
    std::vector<double> open;
    for (const auto& [begin, end] : slices) {
      // Times are written to 1 ns.
      while (!open.empty() && open.back() <= begin + 0.0015) open.pop_back();
      if (!open.empty()) {
        EXPECT_LE(end, open.back() + 0.0015) << track.first << " at " << begin;
      }
      open.push_back(end);
    }
  }
}

void expect_shares(const json& trace) {
  double sum = 0.0;
  for (const auto& [place, share] : trace["otherData"]["critical_path"].items()) {
    EXPECT_GE(share.get<double>(), 0.0) << place;
    sum += share.get<double>();
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);  // of sums over thousands of pieces
}

/// Advances in the trace that are marked as rolled back, and how many the run says it discarded.
std::size_t rolled_back(const json& trace) {
  std::size_t count = 0;
  for (const json& event : trace.at("traceEvents")) {
    const std::string name = event.at("name");
    count += event.at("ph") == "X" && name.find("advance (rolled back)") != std::string::npos;
  }
  return count;
}

std::size_t discarded_calls(const std::filesystem::path& run) {
  const Ended log = tandem_command({"log", run.string()});
  const std::size_t at = log.output.find(" discarded by rollback");
  const std::size_t begin = log.output.rfind('(', at) + 1;
  return std::stoul(log.output.substr(begin, at - begin));
}

class RunTrace : public testing::Test {
 protected:
  void run(const std::vector<std::string>& more) const {
    std::vector<std::string> all{"--set", "run.duration_s=0.05"};
    all.insert(all.end(), more.begin(), more.end());
    const Ended ended = run_command(run_of("two_masses", folder_ / "run", all));
    ASSERT_EQ(ended.code, 0) << ended.output;
  }
  TemporaryFolder folder_{"tandem_trace"};
};

TEST_F(RunTrace, ShowsBothProcessesTheirExchangesAndWhatWasRolledBack) {
  run({"--scheme", "implicit"});
  const json trace = trace_of(folder_ / "run");
  EXPECT_EQ(processes_of(trace), (std::set<std::string>{"tandem-mbs", "tandem-fem"}));
  EXPECT_GT(expect_forward_arrows(trace), 100U);
  expect_nested_slices(trace);
  expect_shares(trace);
  EXPECT_GT(rolled_back(trace), 0U);
  EXPECT_EQ(rolled_back(trace), discarded_calls(folder_ / "run"));
}

TEST_F(RunTrace, ShowsTheHubBetweenTheSides) {
  run({"--driver", "orchestrator", "--scheme", "explicit_parallel"});
  const json trace = trace_of(folder_ / "run");
  EXPECT_EQ(processes_of(trace), (std::set<std::string>{"tandem", "tandem-mbs", "tandem-fem"}));
  EXPECT_GT(expect_forward_arrows(trace), 10U);
  expect_nested_slices(trace);
  expect_shares(trace);
}

TEST_F(RunTrace, OfOneProcessHasNoArrows) {
  run({"--transport", "inproc"});
  const json trace = trace_of(folder_ / "run");
  EXPECT_EQ(processes_of(trace), (std::set<std::string>{"tandem"}));
  EXPECT_EQ(expect_forward_arrows(trace), 0U);
  expect_nested_slices(trace);
  expect_shares(trace);
}

TEST_F(RunTrace, HoldsTheMacroStepsAskedFor) {
  run({"--transport", "inproc"});
  const json trace = trace_of(folder_ / "run", {"--steps", "3:5"});
  std::set<std::string> steps;
  for (const json& event : trace["traceEvents"]) {
    const std::string name = event["name"];
    if (name.starts_with("macro step ")) steps.insert(name);
  }
  EXPECT_EQ(steps, (std::set<std::string>{"macro step 3", "macro step 4", "macro step 5"}));
  EXPECT_EQ(trace["otherData"]["traced"], (json{3, 5}));
  const Ended wrong = tandem_command({"trace", (folder_ / "run").string(), "--steps", "5:3"});
  EXPECT_EQ(wrong.code, 2) << wrong.output;
}

TEST_F(RunTrace, OfALogWithoutExchangesSaysSo) {
  run({"--transport", "inproc", "--set", "output.log_every_steps=0"});
  const Ended ended = tandem_command({"trace", (folder_ / "run").string()});
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.output.find("output.log_every_steps"), std::string::npos) << ended.output;
}

// Several flexible bodies: one process and one prediction each.
TEST(RunTraceBodies, EachHasATrackOfItsName) {
  const TemporaryFolder folder("tandem_trace");
  const Ended ended =
      run_command(run_of("chain_of_links", folder / "run", {"--set", "run.duration_s=0.01"}));
  ASSERT_EQ(ended.code, 0) << ended.output;
  const json trace = trace_of(folder / "run");
  const std::set<std::string> processes = processes_of(trace);
  EXPECT_TRUE(processes.contains("tandem-fem link1")) << trace["otherData"];
  EXPECT_TRUE(processes.contains("tandem-fem link2"));
  EXPECT_TRUE(trace["otherData"]["run_time_if"].contains("link2"));
  EXPECT_GT(expect_forward_arrows(trace), 10U);
  expect_nested_slices(trace);
  expect_shares(trace);
}

}  // namespace
}  // namespace tandem::test
