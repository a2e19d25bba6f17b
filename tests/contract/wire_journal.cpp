#include <gtest/gtest.h>

#include <thread>

#include "protocol/driver/journaled_side.h"
#include "protocol/wire/journal_receiver.h"
#include "protocol/wire/journal_sender.h"
#include "tests/support/wire_mock_sides.h"

namespace tandem::wire {
namespace {

TEST(JournaledSide, WritesDownEveryCallAndWhichOnesCount) {
  test::CountingFem inner;
  CallJournal journal;
  JournaledFem fem(inner, journal);
  const MotionSet a = test::some_motions(2, 0.1);
  const MotionSet b = test::some_motions(2, 0.2);
  const WrenchSet first = fem.initialize(a);
  auto calls = journal.take();
  ASSERT_EQ(calls.size(), 1U);
  EXPECT_EQ(calls[0].kind, CallKind::Initialize);
  EXPECT_EQ(calls[0].side, SideName::Fem);
  EXPECT_EQ(calls[0].macro_step, 0);
  EXPECT_TRUE(calls[0].accepted);
  EXPECT_EQ(calls[0].motions.end[0].p_WP, a[0].p_WP);
  EXPECT_EQ(calls[0].wrenches.end[1].f_P_W, first[1].f_P_W);

  fem.checkpoint();
  fem.advance({.step = SimTime(5), .input = {a, a}});
  fem.rollback();
  const auto last = fem.advance({.step = SimTime(5), .input = {a, b}, .linearize = true});
  calls = journal.take();
  ASSERT_EQ(calls.size(), 2U);
  EXPECT_TRUE(calls[0].checkpoint_first);
  EXPECT_FALSE(calls[0].rollback_first);
  EXPECT_FALSE(calls[0].accepted);
  EXPECT_EQ(calls[0].iteration, 1);
  EXPECT_FALSE(calls[1].checkpoint_first);
  EXPECT_TRUE(calls[1].rollback_first);
  EXPECT_TRUE(calls[1].accepted);
  EXPECT_TRUE(calls[1].linearize);
  EXPECT_EQ(calls[1].iteration, 2);
  EXPECT_EQ(calls[1].macro_step, 1);
  EXPECT_EQ(calls[1].step, SimTime(5));
  EXPECT_EQ(calls[1].motions.begin[0].v_WP, a[0].v_WP);
  EXPECT_EQ(calls[1].motions.end[0].v_WP, b[0].v_WP);
  EXPECT_EQ(calls[1].wrenches.end[0].f_P_W, last.output[0].f_P_W);
  EXPECT_TRUE(journal.take().empty());
}

class WireJournal : public testing::Test {
 protected:
  std::uint64_t run_ = random_run_id();
  int port_ = free_port();
};

// The driver may be at most `window` macro steps ahead of what is recorded.
TEST_F(WireJournal, CreditBoundsHowFarTheDriverRunsAhead) {
  constexpr int kWindow = 4;
  constexpr std::int64_t kSteps = 60;
  std::atomic<std::int64_t> sent{0};
  std::atomic<std::int64_t> recorded{0};
  std::thread driver([&] {
    Bus bus({.self = Process::Mbs, .run_id = run_, .port = port_});
    Heartbeat heartbeat(bus, 5.0);
    LivenessMonitor monitor(bus, {Process::Orchestrator}, 5.0);
    JournalSender sender(bus, monitor, kWindow);
    for (std::int64_t step = 0; step < kSteps; ++step) {
      StepJournal journal;
      journal.step.macro_step = step;
      sender.send(journal);
      sent = step + 1;
      // What is recorded only grows, so reading it afterwards is on the safe side.
      EXPECT_LE(sent - recorded, kWindow);
    }
    sender.finish({.exit_code = 3, .message = "diverged", .summary_json = "{}"});
  });
  Bus bus({.self = Process::Orchestrator, .run_id = run_, .port = port_});
  Heartbeat heartbeat(bus, 5.0);
  LivenessMonitor monitor(bus, {Process::Mbs}, 5.0);
  JournalReceiver receiver(bus, monitor, kWindow);
  bool finished = false;
  for (const double end_s = now_s() + 20.0; !finished && now_s() < end_s;) {
    const auto entry = receiver.next(0.1);
    if (!entry) continue;
    if (const auto* journal = std::get_if<StepJournal>(&*entry)) {
      EXPECT_EQ(journal->step.macro_step, recorded);
      std::this_thread::sleep_for(std::chrono::microseconds(500));
      ++recorded;
    } else {
      EXPECT_EQ(std::get<Finished>(*entry).exit_code, 3);
      EXPECT_EQ(std::get<Finished>(*entry).message, "diverged");
      finished = true;
    }
    receiver.recorded();
  }
  EXPECT_TRUE(finished);
  EXPECT_EQ(recorded, kSteps);
  driver.join();
}

TEST_F(WireJournal, AWindowOfZeroIsRefused) {
  Bus bus({.self = Process::Mbs, .run_id = run_, .port = port_});
  LivenessMonitor monitor(bus, {}, 5.0);
  EXPECT_THROW(JournalSender(bus, monitor, 0), Error);
}

CallRecord call_of(SideName side, CallKind kind, std::size_t motions, std::size_t wrenches) {
  CallRecord call;
  call.side = side;
  call.kind = kind;
  call.motions.end.resize(motions);
  call.wrenches.end.resize(wrenches);
  if (kind != CallKind::Advance) return call;
  if (side == SideName::Mbs) call.wrenches.begin.resize(wrenches);
  if (side == SideName::Fem) call.motions.begin.resize(motions);
  return call;
}

TEST(CallRecord, HasASizeForEachEndOfEachKind) {
  for (const SideName side : {SideName::Mbs, SideName::Fem}) {
    for (const CallKind kind : {CallKind::Initialize, CallKind::Advance}) {
      EXPECT_EQ(misfit(call_of(side, kind, 2, 2), 2), "");
      EXPECT_NE(misfit(call_of(side, kind, 2, 2), 3), "");
      EXPECT_NE(misfit(call_of(side, kind, 2, 1), 2), "");
      EXPECT_NE(misfit(call_of(side, kind, 0, 0), 2), "");
    }
    EXPECT_EQ(misfit(call_of(side, CallKind::Command, 0, 0), 2), "");
    EXPECT_NE(misfit(call_of(side, CallKind::Command, 2, 2), 2), "");
  }
  CallRecord failed = call_of(SideName::Fem, CallKind::Advance, 2, 0);
  EXPECT_NE(misfit(failed, 2), "");
  failed.outcome = Outcome::Failed;  // without an output
  EXPECT_EQ(misfit(failed, 2), "");
}

// Numbers that no driver with this window can have reached yet take no room from the one that is
// waited for.
TEST_F(WireJournal, WhatIsFarAheadDoesNotKeepOutTheOneThatIsWaitedFor) {
  constexpr int kWindow = 8;
  Bus bus({.self = Process::Orchestrator, .run_id = run_, .port = port_});
  Bus other({.self = Process::Mbs, .run_id = run_, .port = port_});
  LivenessMonitor monitor(bus, {Process::Mbs}, 5.0);
  JournalReceiver receiver(bus, monitor, kWindow);
  const auto send = [&](std::int64_t number) {
    StepJournal journal;
    journal.step.macro_step = number;
    Bytes message = encode(other.header(Kind::Journal, number), journal);
    other.publish(Process::Orchestrator, Kind::Journal, message);
    return receiver.next(0.0);
  };
  for (std::int64_t number = 2; number < 5000; ++number) EXPECT_FALSE(send(number).has_value());
  auto entry = send(1);
  for (std::int64_t number = 1; number <= kWindow; ++number) {
    if (!entry) entry = receiver.next(1.0);
    ASSERT_TRUE(entry.has_value()) << number;
    EXPECT_EQ(std::get<StepJournal>(*entry).step.macro_step, number);
    receiver.recorded();
    entry.reset();
  }
}

}  // namespace
}  // namespace tandem::wire
