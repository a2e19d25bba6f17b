#pragma once

#include <chrono>
#include <cstdint>

namespace tandem {

/// Seconds since an arbitrary origin on this process's monotonic clock: for durations only.
[[nodiscard]] inline double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Where the time and bytes of one call to a side went. A local side fills compute_s alone. Times
/// are durations measured inside one process each, so no clock is shared between processes.
struct CallCost {
  double compute_s = 0.0;  ///< inside the side's own advance
  double encode_s = 0.0;   ///< both processes
  double decode_s = 0.0;   ///< both processes
  double publish_s = 0.0;  ///< inside the publish calls of both processes
  double transit_s = 0.0;  ///< round trip minus everything both processes book as their own time
  std::int64_t messages = 0;
  std::int64_t bytes = 0;
  std::int64_t resent = 0;      ///< requests sent again after a time-out
  std::int64_t duplicates = 0;  ///< messages that arrived more than once and were not used again

  /// All times together: how long the call takes when nothing else is done meanwhile.
  [[nodiscard]] double total_s() const {
    return compute_s + encode_s + decode_s + publish_s + transit_s;
  }

  CallCost& operator+=(const CallCost& other) {
    compute_s += other.compute_s;
    encode_s += other.encode_s;
    decode_s += other.decode_s;
    publish_s += other.publish_s;
    transit_s += other.transit_s;
    messages += other.messages;
    bytes += other.bytes;
    resent += other.resent;
    duplicates += other.duplicates;
    return *this;
  }
};

}  // namespace tandem
