#pragma once

#include <cstdint>
#include <vector>

namespace tandem::orchestrator {

/// What one exchange says of another process's clock against the driver's: a message is not there
/// before it was sent, so that with offset = that clock − the driver's clock
///   reply's sending there − its arrival here ≤ offset ≤ request's arrival there − its sending
///   here.
struct OffsetBounds {
  double at_s = 0.0;  ///< on the driver's clock
  double low_s = 0.0;
  double high_s = 0.0;
};

/// offset(t) = offset_s + drift (t − origin_s), as far as possible within all bounds.
struct ClockFit {
  double origin_s = 0.0;
  double offset_s = 0.0;
  double drift = 0.0;           ///< s/s
  double median_error_s = 0.0;  ///< the true offset of an exchange is not further from the line
  double largest_error_s = 0.0;
  std::int64_t outside =
      0;  ///< exchanges that no line of such drift meets: their own bounds are taken

  /// The offset during an exchange: the line's, or the nearest that the exchange allows.
  [[nodiscard]] double offset(const OffsetBounds& exchange) const;
};

/// The line whose least distance to a bound is largest, among drifts of at most ±1e-3 (clocks are
/// steered by 5e-4). The least distance is concave in the drift, so a golden section finds it.
[[nodiscard]] ClockFit fit_clock(const std::vector<OffsetBounds>& exchanges);

}  // namespace tandem::orchestrator
