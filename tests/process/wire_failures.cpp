#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "protocol/contract/cost.h"
#include "tests/support/wire_run.h"

// Whoever is killed, stopped, missing or of another version: the others end within the time-out
// (here 1 s) and 2 s, with the right exit code and a text that names the process and the cause.
namespace tandem::wire {
namespace {

using test::ChildProcess;
using test::PeerRun;

constexpr double kTimeout_s = 1.0;
constexpr double kLimit_s = kTimeout_s + 2.0;
const std::string kTimeout = "timeout_s=1";

void expect_end(ChildProcess& child, int exit_code, const std::string& text) {
  EXPECT_EQ(child.wait(kLimit_s), exit_code) << child.output();
  EXPECT_NE(child.value("error").find(text), std::string::npos) << child.output();
}

void pause_s(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

TEST(WireFailures, FemNeverStarted) {
  const PeerRun run;
  const auto mbs = run.start("mbs", {kTimeout});
  expect_end(*mbs, 4, "tandem-fem has not been heard within 1 s: it was not started");
}

TEST(WireFailures, MbsNeverStarted) {
  const PeerRun run;
  const auto fem = run.start("fem", {kTimeout});
  expect_end(*fem, 4, "tandem-mbs has not been heard within 1 s: it was not started");
}

TEST(WireFailures, OrchestratorNeverStarted) {
  const PeerRun run;
  const auto fem = run.start("fem", {kTimeout, "window=4"});
  const auto mbs = run.start("mbs", {kTimeout, "window=4", "steps=100000"});
  EXPECT_EQ(mbs->wait(kLimit_s), 4);
  EXPECT_EQ(fem->wait(kLimit_s), 4);
  EXPECT_NE((mbs->output() + fem->output()).find("tandem (the orchestrator) has not been heard"),
            std::string::npos);
}

struct Endless {
  PeerRun run;
  std::unique_ptr<ChildProcess> orchestrator, fem, mbs;
  explicit Endless(const std::string& more = "ports=2") {
    const std::vector<std::string> arguments{kTimeout, "window=8", "steps=100000000", more};
    orchestrator = run.start("orchestrator", arguments);
    fem = run.start("fem", arguments);
    mbs = run.start("mbs", arguments);
    pause_s(0.4);
  }
};

class WireFailuresInMidRun : public testing::TestWithParam<int> {};

TEST_P(WireFailuresInMidRun, FemDies) {
  const Endless all;
  all.fem->signal(GetParam());
  expect_end(*all.mbs, 4, "tandem-fem");
  expect_end(*all.orchestrator, 4, "tandem-fem");
}

TEST_P(WireFailuresInMidRun, MbsDies) {
  const Endless all;
  all.mbs->signal(GetParam());
  expect_end(*all.fem, 4, "tandem-mbs");
  expect_end(*all.orchestrator, 4, "tandem-mbs");
}

TEST_P(WireFailuresInMidRun, OrchestratorDies) {
  const Endless all;
  all.orchestrator->signal(GetParam());
  expect_end(*all.mbs, 4, "tandem (the orchestrator)");
  expect_end(*all.fem, 4, "tandem (the orchestrator)");
}

INSTANTIATE_TEST_SUITE_P(Signals, WireFailuresInMidRun, testing::Values(SIGKILL, SIGSTOP));

// The side's error ends everybody with the side's own exit code and text, at once.
TEST(WireFailures, AnErrorOfTheSideReachesEverybodyWithItsText) {
  const PeerRun run;
  const auto orchestrator = run.start("orchestrator", {"window=4"});
  const auto fem = run.start("fem", {"throw_at=5", "window=4"});
  const auto mbs = run.start("mbs", {"window=4"});
  const double begin_s = now_s();
  for (const auto& child : {orchestrator.get(), fem.get(), mbs.get()}) {
    EXPECT_EQ(child->wait(3.0), 3) << child->output();
    EXPECT_NE(child->value("error").find("Newton stalled at t = 0.412 s. Halve h."),
              std::string::npos)
        << child->output();
  }
  EXPECT_LT(now_s() - begin_s, 2.0);
  EXPECT_EQ(mbs->value("error").find("fem: Newton"), 0U) << mbs->output();
}

TEST(WireFailures, AServerWhoseParentHasGoneEnds) {
  const PeerRun run;
  // Whoever has this number is not the child's parent.
  const auto fem = run.start("fem", {"timeout_s=60", "parent=1000000000"});
  expect_end(*fem, 4, "the process that started it (pid 1000000000) has ended");
}

// Two steps of 1.5 s with a time-out of 1 s: the heartbeat goes on while the solver works.
TEST(WireFailures, ALongStepIsNotAFailure) {
  const PeerRun run;
  const auto fem = run.start("fem", {kTimeout, "sleep_ms=1500"});
  const auto mbs = run.start("mbs", {kTimeout, "steps=1", "k=2"});
  EXPECT_EQ(mbs->wait(8.0), 0) << mbs->output();
  EXPECT_EQ(fem->wait(3.0), 0) << fem->output();
  EXPECT_EQ(fem->value("advances"), "2");
}

// Everybody stopped and continued together, as by Ctrl-Z and fg: nobody is to blame.
TEST(WireFailures, StoppingAndContinuingAllIsNotAFailure) {
  const PeerRun run;
  const auto fem = run.start("fem", {kTimeout, "sleep_ms=5"});
  const auto mbs = run.start("mbs", {kTimeout, "steps=100", "k=1"});
  pause_s(0.2);
  fem->signal(SIGSTOP);
  mbs->signal(SIGSTOP);
  pause_s(1.5);
  fem->signal(SIGCONT);
  mbs->signal(SIGCONT);
  EXPECT_EQ(mbs->wait(5.0), 0) << mbs->output();
  EXPECT_EQ(fem->wait(3.0), 0) << fem->output();
}

struct Mismatch {
  std::string fem, mbs, text;
};
class WireHandshake : public testing::TestWithParam<Mismatch> {};

TEST_P(WireHandshake, AMismatchIsAUsageErrorOnBothEnds) {
  const PeerRun run;
  const auto fem = run.start("fem", {GetParam().fem});
  const auto mbs = run.start("mbs", {GetParam().mbs});
  EXPECT_EQ(mbs->wait(3.0), 2) << mbs->output();
  EXPECT_NE(mbs->value("error").find(GetParam().text), std::string::npos) << mbs->output();
  EXPECT_EQ(fem->wait(3.0), 2) << fem->output();
  EXPECT_NE(fem->value("error").find(GetParam().text), std::string::npos) << fem->output();
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, WireHandshake,
    testing::Values(Mismatch{"hash=1", "hash=2", "scenario hash 0000000000000002 there"},
                    Mismatch{"version=1.0", "version=1.1", "Tandem 1.1 there, 1.0 here"},
                    Mismatch{"ports=3", "ports=2", "ports [p0, p1] there, [p0, p1, p2] here"}));

}  // namespace
}  // namespace tandem::wire
