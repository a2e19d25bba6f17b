#include "orchestrator/record/critical_path.h"

#include <gtest/gtest.h>

#include <numeric>

#include "orchestrator/record/path_book.h"

// Made-up macro steps whose critical path can be read off: worker 0 computes in the driver, the
// others elsewhere. Times are small whole numbers (s), so that sums are exact.
namespace tandem::orchestrator {
namespace {

constexpr std::size_t kWorkers = 3;

Errand own(double start_s, double end_s) {
  return {.worker = 0,
          .here = true,
          .sent_s = start_s,
          .awaited_s = start_s,
          .arrived_s = end_s,
          .start_s = start_s,
          .end_s = end_s};
}

/// On the way for 1 s each time, decoded and encoded for 1 s each.
Errand elsewhere(std::size_t worker, double sent_s, double awaited_s, double compute_s) {
  const double start_s = sent_s + 2.0;
  const double end_s = start_s + compute_s;
  return {.worker = worker,
          .sent_s = sent_s,
          .awaited_s = awaited_s,
          .arrived_s = end_s + 2.0,
          .start_s = start_s,
          .end_s = end_s,
          .decode_s = 1.0,
          .encode_s = 1.0};
}

/// Worker 0 for 10 s; then worker 1, asked at 13, for 20 s, there at 37; recorded from 40 to 44,
/// credit to 45.
StepTimes alternating() {
  StepTimes step;
  step.whole = {0.0, 45.0};
  step.calls = {{0.0, 10.0}, {12.0, 38.0}};
  step.errands = {own(0.0, 10.0), elsewhere(1, 13.0, 13.0, 20.0)};
  step.recording_s = 4.0;
  step.credit_s = 1.0;
  return step;
}

/// Both bodies asked in one call, waited for in their order: the first for 20 s, the second for
/// `second_s`, behind 10 s of worker 0.
StepTimes together(double second_s) {
  StepTimes step;
  const Errand first = elsewhere(1, 11.0, 12.0, 20.0);  // there at 35
  Errand second = elsewhere(2, 12.0, 36.0, second_s);
  const double end_s = std::max(36.0, second.arrived_s) + 1.0;
  if (second.arrived_s <= 36.0) second.awaited_s = 36.0;
  step.whole = {0.0, end_s};
  step.calls = {{0.0, 10.0}, {10.0, end_s}};
  step.errands = {own(0.0, 10.0), first, second};
  return step;
}

std::vector<double> seconds_at(const StepTimes& step) {
  std::vector<double> place_s(kWorkers + kTolls);
  for (const PathPiece& piece : critical_path(step, kWorkers)) {
    place_s[piece.place] += piece.time.end_s - piece.time.begin_s;
  }
  return place_s;
}

std::size_t at(Toll toll) { return place_of(toll, kWorkers); }

void expect_cover(const StepTimes& step) {
  const auto path = critical_path(step, kWorkers);
  ASSERT_FALSE(path.empty());
  EXPECT_EQ(path.front().time.begin_s, step.whole.begin_s);
  EXPECT_EQ(path.back().time.end_s, step.whole.end_s);
  for (std::size_t i = 1; i < path.size(); ++i) {
    EXPECT_EQ(path[i].time.begin_s, path[i - 1].time.end_s);
  }
}

TEST(CriticalPath, OfSidesThatAlternateIsTheWholeStep) {
  const StepTimes step = alternating();
  expect_cover(step);
  const std::vector<double> s = seconds_at(step);
  EXPECT_EQ(s[0], 10.0);
  EXPECT_EQ(s[1], 20.0);
  EXPECT_EQ(s[2], 0.0);
  EXPECT_EQ(s[at(Toll::Wire)], 2.0);
  EXPECT_EQ(s[at(Toll::Coding)], 1.0 + 2.0 + 1.0);  // 12 … 13, in the other process, 37 … 38
  EXPECT_EQ(s[at(Toll::Driver)], 2.0 + 2.0);        // 10 … 12, 38 … 40
  EXPECT_EQ(s[at(Toll::Recording)], 4.0);
  EXPECT_EQ(s[at(Toll::Credit)], 1.0);
}

TEST(CriticalPath, GoesThroughTheBodyThatAnswersLast) {
  const StepTimes longer = together(30.0);  // asked at 12, there at 46
  expect_cover(longer);
  EXPECT_EQ(seconds_at(longer)[1], 0.0);
  EXPECT_EQ(seconds_at(longer)[2], 30.0);
  EXPECT_EQ(seconds_at(longer)[at(Toll::Wire)], 2.0);
  const StepTimes shorter = together(5.0);  // was there long before it was waited for
  expect_cover(shorter);
  EXPECT_EQ(seconds_at(shorter)[1], 20.0);
  EXPECT_EQ(seconds_at(shorter)[2], 0.0);
}

// explicit_parallel: asked, then the driver computes itself; the reply lies there when it looks.
TEST(CriticalPath, StaysWithTheDriverWhereItOnlyFindsTheReply) {
  StepTimes step;
  step.whole = {0.0, 33.0};
  step.calls = {{0.0, 33.0}, {2.0, 30.0}};
  Errand found = elsewhere(1, 1.0, 30.0, 10.0);
  found.arrived_s = 31.0;  // read then; it was sent at 14
  step.errands = {own(2.0, 30.0), found};
  expect_cover(step);
  const std::vector<double> s = seconds_at(step);
  EXPECT_EQ(s[0], 28.0);
  EXPECT_EQ(s[1], 0.0);
  EXPECT_EQ(s[at(Toll::Wire)], 1.0);
  // Ten times slower it would be the one that is waited for: from 1, 2 + 100 s, encoded, read.
  EXPECT_EQ(duration_if(step, 1, 10.0), 1.0 + 2.0 + 100.0 + 1.0 + 2.0);
}

TEST(CriticalPath, MarksWhatWasRolledBack) {
  StepTimes step = alternating();
  step.errands[1].discarded = true;
  double discarded_s = 0.0;
  for (const PathPiece& piece : critical_path(step, kWorkers)) {
    if (piece.discarded) discarded_s += piece.time.end_s - piece.time.begin_s;
  }
  EXPECT_EQ(discarded_s, 24.0);  // 13 … 37
}

TEST(CriticalPath, PredictsTheStepWithAFasterBody) {
  for (std::size_t worker = 0; worker < kWorkers; ++worker) {
    EXPECT_EQ(duration_if(alternating(), worker, 1.0), 45.0) << worker;
    EXPECT_EQ(duration_if(together(30.0), worker, 1.0), 47.0) << worker;
    EXPECT_EQ(duration_if(together(5.0), worker, 1.0), 37.0) << worker;
  }
  EXPECT_EQ(duration_if(alternating(), 0, 0.5), 40.0);
  EXPECT_EQ(duration_if(alternating(), 1, 0.5), 35.0);
  EXPECT_EQ(duration_if(alternating(), 2, 0.5), 45.0);
  // Of two at the same time the shorter gains nothing, and the longer no more than down to the
  // other: that one is there at 35, its reply taken to 36, the step over at 37.
  EXPECT_EQ(duration_if(together(30.0), 1, 0.0), 47.0);
  EXPECT_EQ(duration_if(together(30.0), 2, 0.8), 41.0);
  EXPECT_EQ(duration_if(together(30.0), 2, 0.0), 37.0);
  // The other that was there at 21, before it was waited for, is waited for then.
  EXPECT_EQ(duration_if(together(5.0), 1, 0.0), 22.0);
}

TEST(PathBook, SharesAreOfTheWholeAndTheBestGainComesFirst) {
  PathBook book({"mbs", "crank", "rod"}, {true, false, false});
  for (const StepTimes& step : {alternating(), together(30.0), together(5.0)}) {
    book.add(book.steps() + 1, step, critical_path(step, kWorkers));
  }
  EXPECT_EQ(book.total_s(), 45.0 + 47.0 + 37.0);
  const std::vector<double> shares = book.shares();
  EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), 1.0, 1e-15);
  EXPECT_DOUBLE_EQ(shares[0], 30.0 / 129.0);
  EXPECT_DOUBLE_EQ(shares[1], 40.0 / 129.0);
  EXPECT_DOUBLE_EQ(shares[2], 30.0 / 129.0);
  EXPECT_EQ(book.led(), (std::vector<double>{0, 2.0 / 3, 1.0 / 3, 0, 0, 0, 0, 0}));
  ASSERT_EQ(book.predictions().size(), 3U);
  EXPECT_EQ(book.predictions()[0].worker, 1U);  // 10 + 0 + 10 s less at half its time
  EXPECT_DOUBLE_EQ(book.predictions()[0].twice_as_fast, 1.0 - 20.0 / 129.0);
  EXPECT_EQ(book.slowest().front().macro_step, 2);
  // The driver waits 24 s for the first body alone, then 23 + 10 s and 23 + 0 s for both.
  const auto waits = book.waits();
  EXPECT_NEAR(std::accumulate(waits[0].begin(), waits[0].end(), 0.0), 80.0 / 129.0, 1e-15);
  EXPECT_TRUE(waits[1].empty());
  // The second body is idle in all of the first step, and for what it is then in each of the
  // others.
  EXPECT_NEAR(std::accumulate(waits[3].begin(), waits[3].end(), 0.0),
              (45.0 + 47.0 - 32.0 + 37.0 - 7.0) / 129.0, 1e-15);
}

}  // namespace
}  // namespace tandem::orchestrator
