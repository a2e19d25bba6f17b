// For how long a receiver polls: about as long as waits last, and not where it loses its core.
#include "protocol/wire/poll_budget.h"

#include <gtest/gtest.h>

namespace tandem::wire {
namespace {

/// Waits of one length, so many that the budget has settled.
void settle(PollBudget& budget, double waited_s) {
  for (int i = 0; i < 400; ++i) {
    static_cast<void>(budget.begin());
    budget.end(waited_s);
  }
}

TEST(PollBudget, FollowsWhatWaitsTake) {
  PollBudget budget(Wait::Adaptive);
  EXPECT_GT(budget.begin(), 0.0);
  EXPECT_LT(budget.begin(), 1e-4);
  for (const double waited_s : {1e-5, 1e-4, 8e-4}) {
    settle(budget, waited_s);
    EXPECT_GT(budget.begin(), 1.5 * waited_s);
    EXPECT_LE(budget.begin(), PollBudget::kLongest_s);
  }
}

TEST(PollBudget, DoesNotPollThroughLongWaits) {
  PollBudget budget(Wait::Adaptive);
  settle(budget, 0.05);
  EXPECT_EQ(budget.begin(), 0.0);
  // Nor for one short wait among long ones.
  budget.end(1e-5);
  EXPECT_EQ(budget.begin(), 0.0);
  settle(budget, 1e-5);
  EXPECT_GT(budget.begin(), 0.0);
}

/// Waits in a row that block at once.
int left_off(PollBudget& budget) {
  int count = 0;
  while (budget.begin() == 0.0) {
    budget.end(1e-5);
    ++count;
  }
  return count;
}

TEST(PollBudget, LeavesOffWhereOthersNeedTheCore) {
  PollBudget budget(Wait::Adaptive);
  budget.preempted();
  const int first = left_off(budget);
  EXPECT_GT(first, 0);
  // Again and again: polling then is a small part of all waits.
  int last = first;
  for (int i = 0; i < 20; ++i) {
    budget.preempted();
    const int next = left_off(budget);
    EXPECT_GE(next, last);
    last = next;
  }
  EXPECT_GT(last, 1000);
  EXPECT_LT(last, 10000);
  // Once the core is its own again, one preemption is a small thing.
  settle(budget, 1e-5);
  budget.preempted();
  EXPECT_EQ(left_off(budget), first);
}

TEST(PollBudget, ObeysWhatIsAskedFor) {
  PollBudget block(Wait::Block);
  settle(block, 1e-6);
  EXPECT_EQ(block.begin(), 0.0);
  PollBudget poll(Wait::Poll);
  settle(poll, 1.0);
  poll.preempted();
  EXPECT_EQ(poll.begin(), PollBudget::kLongest_s);
}

}  // namespace
}  // namespace tandem::wire
