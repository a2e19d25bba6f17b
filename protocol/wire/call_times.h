#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem::wire {

/// When one body was asked and had answered in a call. `sent_s`, `awaited_s` and `arrived_s` are on
/// the driver's clock (now_s()), the durations on that of the body's process, `side_us` on the wall
/// clock there: what relates the two clocks.
struct PartTimes {
  double sent_s = 0.0;     ///< first handed to the network; of a body in this process: begun
  double awaited_s = 0.0;  ///< from here the driver had nothing to do but to wait for it
  double arrived_s = 0.0;  ///< the reply was here; of a body in this process: done
  double side_us = 0.0;    ///< when its computing ended, µs since 1970; 0: in this process
  double compute_s = 0.0;  ///< with the rollback or checkpoint before it
  double decode_s = 0.0;   ///< of the request, before the computing
  double encode_s = 0.0;   ///< of the reply, behind it
};

/// When a call was made, on the driver's clock.
struct CallTimes {
  double begin_s = 0.0;
  double end_s = 0.0;            ///< 0: not known
  std::vector<PartTimes> parts;  ///< none: one body, in the driver's process, from begin to end
};

/// A side that can tell more of its last call than its caller sees.
class TimedCalls {
 public:
  virtual ~TimedCalls() = default;
  virtual void append_times(std::vector<PartTimes>& to) const = 0;
};

/// Microseconds since 1970: for reading logs only.
[[nodiscard]] inline std::int64_t wall_clock_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace tandem::wire
