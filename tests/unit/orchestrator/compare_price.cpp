// What tandem compare says of the price of transfer, from wall times that are made up.
#include <gtest/gtest.h>

#include "orchestrator/study/compare.h"

namespace tandem::orchestrator {
namespace {

ComparedRuns runs(Mode mode, std::vector<double> wall_s) {
  ComparedRuns made{.mode = mode, .scheme = "implicit", .wall_s = std::move(wall_s)};
  made.summary = {{"macro_steps", 1000},
                  {"ledger_s",
                   {{"encode", 1e-3},
                    {"decode", 2e-3},
                    {"publish", 3e-3},
                    {"transit", 4e-3},
                    {"wait", 5e-3},
                    {"fem_compute", 7e-1}}}};
  return made;
}

// 0.1 s, 0.11 s and 0.13 s more for 1000 steps.
TEST(ComparePrice, GivesTheIntervalOfTheRepetitionsBesideTheLedgersSum) {
  const ComparedRuns mono = runs(Mode::Monolithic, {1.0, 1.0, 1.0});
  const ComparedRuns inproc = runs(Mode::Inproc, {1.0, 2.0, 1.0});
  const ComparedRuns lcm = runs(Mode::Lcm, {1.1, 2.11, 1.13});
  const Spread transfer = transfer_us_per_step(lcm, inproc);
  EXPECT_NEAR(transfer.median, 110.0, 1e-9);
  EXPECT_NEAR(transfer.min, 100.0, 1e-9);
  EXPECT_NEAR(transfer.max, 130.0, 1e-9);
  EXPECT_TRUE(transfer.differs_from(0.0));
  EXPECT_NEAR(booked_transfer_us(lcm), 15.0, 1e-9);
  const std::string text = price_text("implicit", mono, inproc, lcm);
  for (const char* part : {"110.0 µs per macro step (100.0 … 130.0 µs in 3", "15.0 µs",
                           "conclusion: the run over LCM takes +10.0 %, +5.5 … +13.0 %"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is missing in: " << text;
  }
}

// A machine with other work to do: one difference is negative, so the sign is not known. A single
// repetition tells as little.
TEST(ComparePrice, SaysThatItIsNotResolvedWhereTheIntervalHoldsZero) {
  const ComparedRuns mono = runs(Mode::Monolithic, {1.0, 1.0, 1.0});
  for (const std::vector<double>& wall_s : {std::vector{0.8, 1.2, 1.1}, std::vector{1.5}}) {
    const std::vector<double> ones(wall_s.size(), 1.0);
    const ComparedRuns inproc = runs(Mode::Inproc, ones), lcm = runs(Mode::Lcm, wall_s);
    EXPECT_FALSE(transfer_us_per_step(lcm, inproc).differs_from(0.0));
    const std::string text = price_text("implicit", mono, inproc, lcm);
    EXPECT_NE(text.find("not resolved"), std::string::npos) << text;
    EXPECT_NE(text.find("--repeat"), std::string::npos) << text;
    EXPECT_NE(text.find("15.0 µs"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace tandem::orchestrator
