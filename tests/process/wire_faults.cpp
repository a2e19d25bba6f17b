#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "protocol/wire/event_log.h"
#include "tests/support/preload.h"
#include "tests/support/wire_mock_sides.h"
#include "tests/support/wire_run.h"

namespace tandem::wire {
namespace {

using test::Environment;
using test::PeerRun;

const std::string kShim = test::fault_shim(TANDEM_FAULT_SHIM);

Environment faults_of(int percent) {
  return {{"LD_PRELOAD", kShim},
          {"TANDEM_FAULT_SEED", "7"},
          {"TANDEM_FAULT_DROP_PERCENT", std::to_string(percent)},
          {"TANDEM_FAULT_DUPLICATE_PERCENT", std::to_string(percent)},
          {"TANDEM_FAULT_REORDER_PERCENT", std::to_string(percent)}};
}

struct Wire {
  int percent;          ///< of the datagrams: lost, and as many doubled, and as many reordered
  std::string receive;  ///< own or lcm
};
void PrintTo(const Wire& wire, std::ostream* out) {
  *out << wire.percent << "_percent_" << wire.receive;
}

class WireFaults : public testing::TestWithParam<Wire> {
 protected:
  // At 20 % every second exchange waits for a time-out or two.
  static int steps() { return GetParam().percent < 20 ? 60 : 12; }
  static std::string receive() { return "receive=" + GetParam().receive; }
};

// 3 advances a step; checkpoints and rollbacks as in drive(): all values would differ
// if one of them were made twice, left out or made out of order.
TEST_P(WireFaults, EveryCallIsMadeExactlyOnce) {
  PeerRun run;
  run.faults = faults_of(GetParam().percent);
  const auto fem = run.start("fem", {receive()});
  const auto mbs = run.start("mbs", {"steps=" + std::to_string(steps()), "k=3", receive()});
  ASSERT_EQ(mbs->wait(60.0), 0) << mbs->output();
  ASSERT_EQ(fem->wait(5.0), 0) << fem->output();
  test::CountingFem local;
  EXPECT_EQ(mbs->value("hash"), std::to_string(test::drive(local, steps(), 3)));
  EXPECT_EQ(fem->value("advances"), std::to_string(3 * steps()));
  EXPECT_EQ(fem->value("checkpoints"), std::to_string(steps() + 1));
  EXPECT_EQ(fem->value("rollbacks"), std::to_string(2 * steps()));
  if (GetParam().percent >= 5) {
    EXPECT_GT(std::stoi(mbs->value("resent")), 0);
    EXPECT_GT(std::stoi(mbs->value("duplicates")), 0);
  }
}

// 70 ports: requests of 14.6 kB and Jacobians of 2.8 MB, which travel in 48 chunks.
TEST_P(WireFaults, JacobiansInManyChunksArriveWhole) {
  PeerRun run;
  run.faults = faults_of(GetParam().percent);
  const auto fem = run.start("fem", {"ports=70", receive()});
  const auto mbs = run.start("mbs", {"ports=70", "steps=4", "k=2", receive()});
  ASSERT_EQ(mbs->wait(60.0), 0) << mbs->output();
  ASSERT_EQ(fem->wait(5.0), 0) << fem->output();
  test::CountingFem local(70);
  EXPECT_EQ(mbs->value("hash"), std::to_string(test::drive(local, 4, 2)));
  EXPECT_EQ(fem->value("advances"), "8");
}

TEST_P(WireFaults, TheLogHoldsEveryMacroStepInOrder) {
  const auto file = std::filesystem::path(testing::TempDir()) /
                    ("wire_faults_" + std::to_string(getpid()) + ".lcm");
  PeerRun run;
  run.faults = faults_of(GetParam().percent);
  const auto orchestrator =
      run.start("orchestrator", {"window=8", "log=" + file.string(), receive()});
  const auto fem = run.start("fem", {"window=8", receive()});
  const auto mbs = run.start("mbs", {"window=8", "steps=" + std::to_string(steps()), receive()});
  ASSERT_EQ(mbs->wait(60.0), 0) << mbs->output();
  ASSERT_EQ(fem->wait(5.0), 0) << fem->output();
  ASSERT_EQ(orchestrator->wait(5.0), 0) << orchestrator->output();
  EXPECT_EQ(orchestrator->value("journals"), std::to_string(steps() + 1));

  LogReader log(file);
  for (int step = 0; step <= steps(); ++step) {
    const auto journal = log.next_step();
    ASSERT_TRUE(journal.has_value()) << step;
    EXPECT_EQ(journal->step.macro_step, step);
    ASSERT_EQ(journal->calls.size(), step == 0 ? 1U : 2U);
    EXPECT_TRUE(journal->calls.back().accepted);
    if (step == 0) continue;
    EXPECT_FALSE(journal->calls.front().accepted);
    EXPECT_TRUE(journal->calls.front().checkpoint_first);
    EXPECT_TRUE(journal->calls.back().rollback_first);
    EXPECT_EQ(journal->calls.back().iteration, 2);
  }
  EXPECT_FALSE(log.next_step().has_value());
  EXPECT_FALSE(log.truncated());
  std::filesystem::remove(file);
}

INSTANTIATE_TEST_SUITE_P(Percent, WireFaults,
                         testing::Values(Wire{0, "own"}, Wire{1, "own"}, Wire{5, "own"},
                                         Wire{20, "own"}, Wire{0, "lcm"}, Wire{5, "lcm"}));

TEST(WireFaultKinds, FlippedBitsAreDroppedAndRepaired) {
  PeerRun run;
  run.faults = {{"LD_PRELOAD", kShim}, {"TANDEM_FAULT_FLIP_PERCENT", "10"}};
  const auto fem = run.start("fem");
  const auto mbs = run.start("mbs", {"steps=30", "k=3"});
  ASSERT_EQ(mbs->wait(60.0), 0) << mbs->output();
  ASSERT_EQ(fem->wait(5.0), 0) << fem->output();
  test::CountingFem local;
  EXPECT_EQ(mbs->value("hash"), std::to_string(test::drive(local, 30, 3)));
  EXPECT_GT(std::stoi(fem->value("damaged")), 0);
}

TEST(WireFaultKinds, RandomSleepsChangeNoBit) {
  PeerRun run;
  run.faults = {{"LD_PRELOAD", kShim}, {"TANDEM_FAULT_SLEEP_US", "5000"}};
  const auto fem = run.start("fem");
  const auto mbs = run.start("mbs", {"steps=30", "k=3"});
  ASSERT_EQ(mbs->wait(60.0), 0) << mbs->output();
  test::CountingFem local;
  EXPECT_EQ(mbs->value("hash"), std::to_string(test::drive(local, 30, 3)));
}

// What Linux grants by default: three datagrams of a full part, where a step of 4096 ports takes 36
// from the driver to the recorder. They are asked for as they can be taken in.
TEST(WireFaultKinds, AReceiveBufferOfTheUsualSizeCarriesManyPorts) {
  PeerRun run;
  run.faults = {{"LD_PRELOAD", kShim}, {"TANDEM_FAULT_RECEIVE_BUFFER", "212992"}};
  const std::vector<std::string> arguments{"window=64", "ports=4096", "steps=40"};
  const auto orchestrator = run.start("orchestrator", arguments);
  const auto fem = run.start("fem", arguments);
  const auto mbs = run.start("mbs", arguments);
  ASSERT_EQ(mbs->wait(60.0), 0) << mbs->output();
  ASSERT_EQ(orchestrator->wait(5.0), 0) << orchestrator->output();
  EXPECT_EQ(orchestrator->value("journals"), "41");
  EXPECT_EQ(fem->wait(5.0), 0) << fem->output();
  // Nobody had to wait for a time-out of 20 ms in most steps.
  EXPECT_LT(std::stoi(mbs->value("resent")), 20) << mbs->output();
  EXPECT_LT(std::stoi(mbs->value("journals_resent")), 20) << mbs->output();
}

// A blocked wire shows at opening, within the self test's time, not as a hang.
TEST(WireFaultKinds, AMulticastFilterIsReportedAtOpening) {
  PeerRun run;
  run.faults = {{"LD_PRELOAD", kShim}, {"TANDEM_FAULT_DROP_PERCENT", "100"}};
  const auto mbs = run.start("mbs");
  EXPECT_EQ(mbs->wait(4.0), 2);
  EXPECT_NE(mbs->value("error").find("does not hear its own messages"), std::string::npos);
  EXPECT_NE(mbs->value("error").find("firewall"), std::string::npos);
}

}  // namespace
}  // namespace tandem::wire
