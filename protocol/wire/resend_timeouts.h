#pragma once

namespace tandem::wire {

/// How long a message waits for its answer before it is sent again: twice as long every time, from
/// the first of these to the last. Long enough for a process that the scheduler has put aside.
inline constexpr double kFirstTimeout_s = 0.02;
inline constexpr double kLastTimeout_s = 0.2;

}  // namespace tandem::wire
