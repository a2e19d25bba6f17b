#pragma once

#include <cstddef>
#include <vector>

namespace tandem::orchestrator {

/// One body's part of one call, all on the driver's clock (s). The driver asks in one thread:
///   sent ≤ start − decode,  start ≤ end,  end + encode ≤ arrived.
struct Errand {
  std::size_t worker = 0;  ///< which side or body
  bool here = false;       ///< computed by the driver itself, from start to end
  bool discarded = false;  ///< rolled back later
  double sent_s = 0.0;
  double awaited_s = 0.0;  ///< from here the driver waited for it
  double arrived_s = 0.0;
  double start_s = 0.0;  ///< of its computing
  double end_s = 0.0;
  double decode_s = 0.0;
  double encode_s = 0.0;

  /// The driver waited for it, and not only found its reply when it looked.
  [[nodiscard]] bool blocked() const { return !here && end_s > awaited_s; }
  /// Its reply came while another one was waited for.
  [[nodiscard]] bool came_before() const { return !here && arrived_s <= awaited_s; }
};

struct Interval {
  double begin_s = 0.0;
  double end_s = 0.0;
};

/// A macro step from its first call to the first one of the next.
struct StepTimes {
  Interval whole;
  std::vector<Interval> calls;  ///< the driver's, in their order; those begun together overlap
  std::vector<Errand> errands;
  double recording_s = 0.0;  ///< at its end: journal and log
  double credit_s = 0.0;     ///< at the very end: waited until the recorder had caught up
};

/// What time goes to besides the workers' computing.
enum class Toll : std::size_t {
  Wire,       ///< between the processes: kernel, wake-up, a lost message
  Coding,     ///< values to messages and back, both processes
  Driver,     ///< the driver outside of calls: scheme, pace, looks into the books
  Recording,  ///< journal and log
  Credit,     ///< waiting for the recorder
};
inline constexpr std::size_t kTolls = 5;
[[nodiscard]] const char* text_of(Toll toll);

/// Where a stretch of time went: number of a worker, or behind all workers that of a toll.
[[nodiscard]] constexpr std::size_t place_of(Toll toll, std::size_t workers) {
  return workers + static_cast<std::size_t>(toll);
}

struct PathPiece {
  Interval time;
  std::size_t place = 0;
  bool discarded = false;
};

/// The longest chain of work that the end of the macro step waited for: from that end back through
/// what the driver did, and where it was blocked through the process that it waited for, to the
/// request that this one began with. Its pieces are in order and cover the step without a gap.
[[nodiscard]] std::vector<PathPiece> critical_path(const StepTimes& step, std::size_t workers);

/// Duration (s) of the macro step if `worker` computed in `factor` of its time and all else took as
/// long as it did: every request leaves, and every wait ends, as early as that allows. With 1 it is
/// the step's own duration. Cores that processes share are not part of it.
[[nodiscard]] double duration_if(const StepTimes& step, std::size_t worker, double factor);

}  // namespace tandem::orchestrator
