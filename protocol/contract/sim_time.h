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
[[nodiscard]] SimTime sim_time_from_seconds(double seconds);

}  // namespace tandem
