// output.log_every_steps: what the log of a long run leaves out, and that everyone who needs it
// says so.

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <sstream>
#include <string>

#include "protocol/wire/event_log.h"
#include "tests/support/tandem_process.h"

namespace tandem::test {
namespace {

std::set<std::int64_t> logged_steps(const std::filesystem::path& run) {
  wire::LogReader log(run / "exchange.lcm");
  std::set<std::int64_t> steps;
  while (const auto journal = log.next_step()) steps.insert(journal->step.macro_step);
  EXPECT_TRUE(log.finished().has_value());
  return steps;
}

class ThinLog : public testing::Test {
 protected:
  void run(const std::string& every, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"--set", "run.duration_s=0.01", "--set",
                                       "output.log_every_steps=" + every};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = run_command(run_of(example, folder / every, arguments));
    ASSERT_EQ(ended.code, 0) << ended.output;
  }
  void expect_no_replay(const std::string& every, const std::string& held) {
    for (const std::vector<std::string>& how :
         {std::vector<std::string>{"--side", "fem"}, {"--side", "mbs"}, {"--publish"}}) {
      std::vector<std::string> arguments{"replay", (folder / every).string()};
      arguments.insert(arguments.end(), how.begin(), how.end());
      const Ended ended = tandem_command(arguments);
      EXPECT_EQ(ended.code, 2) << ended.output;
      EXPECT_NE(ended.output.find("scenario.yaml:"), std::string::npos) << ended.output;
      EXPECT_NE(ended.output.find("output.log_every_steps: is " + every), std::string::npos)
          << ended.output;
      EXPECT_NE(ended.output.find(held), std::string::npos) << ended.output;
    }
  }
  std::string example = "two_masses";
  const TemporaryFolder folder{"tandem_thin"};
};

TEST_F(ThinLog, HoldsEveryThirdStepAndTheSameResults) {
  run("1");
  run("3");
  EXPECT_EQ(logged_steps(folder / "1").size(), 11U);
  EXPECT_EQ(logged_steps(folder / "3"), (std::set<std::int64_t>{0, 3, 6, 9}));
  const auto hash = [&](const std::string& name) {
    return summary_of(folder / name).at("state_hash").get<std::string>();
  };
  EXPECT_EQ(hash("3"), hash("1"));
  for (const char* table : {"ports.csv", "bodies.csv"}) {
    EXPECT_EQ(read_file(folder / "3" / table), read_file(folder / "1" / table)) << table;
  }
  expect_no_replay("3", "one macro step of 3 alone");
  const Ended told = tandem_command({"log", (folder / "3").string()});
  EXPECT_NE(told.output.find("macro steps  9, of which 3 stand here"), std::string::npos)
      << told.output;
  // Each exchange at its own time, though the one before it is not there.
  const Ended csv = tandem_command({"log", (folder / "3").string(), "--csv"});
  const Ended whole = tandem_command({"log", (folder / "1").string(), "--csv"});
  std::istringstream rows(csv.output);
  int count = 0;
  for (std::string row; std::getline(rows, row); ++count) {
    EXPECT_NE(whole.output.find(row + "\n"), std::string::npos) << row;
  }
  EXPECT_GE(count, 1 + 2 * 4);
}

TEST_F(ThinLog, OffHoldsTheScenarioAndTheEnd) {
  run("0");
  EXPECT_TRUE(logged_steps(folder / "0").empty());
  expect_no_replay("0", "holds no exchange");
  const Ended told = tandem_command({"log", (folder / "0").string()});
  EXPECT_EQ(told.code, 0) << told.output;
  EXPECT_NE(told.output.find("none is here (output.log_every_steps: 0"), std::string::npos)
      << told.output;
  const Ended report = tandem_command({"report", (folder / "0").string()});
  EXPECT_EQ(report.code, 0) << report.output;
}

}  // namespace
}  // namespace tandem::test
