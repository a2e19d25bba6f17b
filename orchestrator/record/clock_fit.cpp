#include "orchestrator/record/clock_fit.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace tandem::orchestrator {
namespace {

constexpr double kMostDrift = 1e-3;
constexpr int kHalvings = 60;  // of the drift's range: to 1e-12

/// The band of offsets at the origin that a drift leaves; empty where `low` is above `high`.
struct Band {
  double low_s = -std::numeric_limits<double>::infinity();
  double high_s = std::numeric_limits<double>::infinity();
  [[nodiscard]] double width_s() const { return high_s - low_s; }
};

Band band_of(const std::vector<OffsetBounds>& exchanges, double origin_s, double drift) {
  Band band;
  for (const OffsetBounds& exchange : exchanges) {
    const double drifted_s = drift * (exchange.at_s - origin_s);
    band.low_s = std::max(band.low_s, exchange.low_s - drifted_s);
    band.high_s = std::min(band.high_s, exchange.high_s - drifted_s);
  }
  return band;
}

double widest_drift(const std::vector<OffsetBounds>& exchanges, double origin_s) {
  double low = -kMostDrift, high = kMostDrift;
  for (int i = 0; i < kHalvings; ++i) {
    const double third = (high - low) / 3.0;
    const double a = band_of(exchanges, origin_s, low + third).width_s();
    const double b = band_of(exchanges, origin_s, high - third).width_s();
    if (a < b) low += third;
    if (a >= b) high -= third;
  }
  return 0.5 * (low + high);
}

}  // namespace

double ClockFit::offset(const OffsetBounds& exchange) const {
  // An exchange that took less time than its server booked, by the resolution of the clocks.
  if (exchange.low_s > exchange.high_s) return 0.5 * (exchange.low_s + exchange.high_s);
  return std::clamp(offset_s + drift * (exchange.at_s - origin_s), exchange.low_s, exchange.high_s);
}

ClockFit fit_clock(const std::vector<OffsetBounds>& exchanges) {
  ClockFit fit;
  if (exchanges.empty()) return fit;
  fit.origin_s = 0.5 * (exchanges.front().at_s + exchanges.back().at_s);
  // One exchange, or some at one time, say nothing of a drift.
  const bool spread = exchanges.back().at_s > exchanges.front().at_s;
  fit.drift = spread ? widest_drift(exchanges, fit.origin_s) : 0.0;
  const Band band = band_of(exchanges, fit.origin_s, fit.drift);
  fit.offset_s = 0.5 * (band.low_s + band.high_s);
  std::vector<double> errors;
  errors.reserve(exchanges.size());
  for (const OffsetBounds& exchange : exchanges) {
    const double line_s = fit.offset_s + fit.drift * (exchange.at_s - fit.origin_s);
    fit.outside += line_s < exchange.low_s || line_s > exchange.high_s ? 1 : 0;
    const double offset_s = fit.offset(exchange);
    errors.push_back(std::max(exchange.high_s - offset_s, offset_s - exchange.low_s));
  }
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  fit.largest_error_s = *std::max_element(errors.begin(), errors.end());
  std::nth_element(errors.begin(), middle, errors.end());
  fit.median_error_s = *middle;
  return fit;
}

}  // namespace tandem::orchestrator
