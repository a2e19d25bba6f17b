#include "protocol/contract/sim_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocol/contract/error.h"

namespace tandem {

SimTime sim_time_from_seconds(double seconds) {
  const double ns = seconds * 1e9;
  require(std::isfinite(ns) && std::abs(ns) < 9.2e18,
          fmt::format("time of {:.6g} s is out of range (±292 years)", seconds));
  const double whole = std::round(ns);
  require(std::abs(whole - ns) <= 1e-6 * std::max(1.0, std::abs(ns)),
          fmt::format("time of {:.6g} ns is not a whole number of nanoseconds. Round it.", ns));
  return SimTime(static_cast<std::int64_t>(whole));
}

}  // namespace tandem
