#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>

#include "protocol/contract/error.h"

namespace tandem {

/// Simulated time and durations: whole nanoseconds, so that n steps of H end exactly at n H. Sums
/// of doubles drift, and two processes that sum differently would disagree about "now".
using SimTime = std::chrono::duration<std::int64_t, std::nano>;

[[nodiscard]] inline constexpr double to_seconds(SimTime t) {
  return static_cast<double>(t.count()) * 1e-9;
}

/// Nearest whole nanosecond. Throws when `seconds` is not finite, beyond ±292 years, or further
/// than 1e-6 relative from a whole nanosecond (a step of 0.3 ns cannot be kept exactly).
[[nodiscard]] inline SimTime sim_time_from_seconds(double seconds) {
  const double ns = seconds * 1e9;
  require(std::isfinite(ns) && std::abs(ns) < 9.2e18,
          "time of " + std::to_string(seconds) + " s is out of range (±292 years)");
  const double whole = std::round(ns);
  require(std::abs(whole - ns) <= 1e-6 * std::max(1.0, std::abs(ns)),
          "time of " + std::to_string(ns) + " ns is not a whole number of nanoseconds. Round it.");
  return SimTime(static_cast<std::int64_t>(whole));
}

}  // namespace tandem
