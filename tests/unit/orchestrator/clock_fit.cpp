#include "orchestrator/record/clock_fit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tandem::orchestrator {
namespace {

constexpr double kOffset_s = 0.25, kDrift = 3e-5;

/// Exchanges every 10 ms with ways of 5 … 45 µs there and back that have nothing to do with each
/// other; every 50th is quick.
std::vector<OffsetBounds> exchanges(double drift) {
  std::vector<OffsetBounds> all;
  for (int i = 0; i < 1000; ++i) {
    const double at_s = 1000.0 + 0.01 * i;
    const double offset_s = kOffset_s + drift * (at_s - 1000.0);
    const double there_s = 1e-6 * (5 + (i * 37) % 50 * 40 / 49);
    const double back_s = 1e-6 * (5 + (i * 61) % 50 * 40 / 49);
    all.push_back({at_s, offset_s - back_s, offset_s + there_s});
  }
  return all;
}

TEST(ClockFit, FindsOffsetAndDrift) {
  for (const double drift : {0.0, kDrift, -2e-4}) {
    const auto all = exchanges(drift);
    const ClockFit fit = fit_clock(all);
    // The quickest ways, of 5 µs, bound the line from both sides all along.
    const double error_s = 5e-6;
    EXPECT_NEAR(fit.offset_s, kOffset_s + drift * (fit.origin_s - 1000.0), error_s);
    EXPECT_NEAR(fit.drift, drift, 2.0 * error_s / 4.0) << "over ±5 s, less the ends";
    EXPECT_EQ(fit.outside, 0);
    for (const OffsetBounds& exchange : all) {
      EXPECT_GE(fit.offset(exchange), exchange.low_s);
      EXPECT_LE(fit.offset(exchange), exchange.high_s);
      EXPECT_LE(std::abs(fit.offset(exchange) - kOffset_s - drift * (exchange.at_s - 1000.0)),
                fit.largest_error_s);
    }
  }
}

// A clock that was set in between: no line meets all, and still no message comes before it is sent.
TEST(ClockFit, KeepsTheBoundsWhereAClockIsSet) {
  auto all = exchanges(0.0);
  for (std::size_t i = all.size() / 2; i < all.size(); ++i) {
    all[i].low_s += 0.1;
    all[i].high_s += 0.1;
  }
  const ClockFit fit = fit_clock(all);
  EXPECT_GT(fit.outside, 0);
  for (const OffsetBounds& exchange : all) {
    EXPECT_GE(fit.offset(exchange), exchange.low_s);
    EXPECT_LE(fit.offset(exchange), exchange.high_s);
  }
}

TEST(ClockFit, TakesTheMiddleOfOneExchange) {
  const ClockFit fit = fit_clock({{7.0, 1.0, 3.0}});
  EXPECT_EQ(fit.offset({7.0, 1.0, 3.0}), 2.0);
  EXPECT_EQ(fit.drift, 0.0);
  EXPECT_EQ(fit.largest_error_s, 1.0);
  EXPECT_EQ(fit_clock({}).offset_s, 0.0);
}

}  // namespace
}  // namespace tandem::orchestrator
