#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "protocol/contract/ledger.h"
#include "protocol/contract/sim_time.h"

namespace tandem {

/// What a run had that was held to the wall clock. The slack of a macro step is what was left of
/// its time when it ended, negative where it was late.
struct PaceReport {
  /// Whom a late step is booked to: the part that took most more than it does on average, or the
  /// longest where none did; of steps that are late for an earlier one, that of the earlier one.
  static constexpr std::array<const char*, 6> kParts = {"mbs",      "fem",    "transfer",
                                                        "recorder", "scheme", "other"};
  double factor = 0.0;    ///< simulated over wall time; 0: as fast as it can
  double waited_s = 0.0;  ///< for steps to be due
  std::int64_t misses = 0;
  std::array<std::int64_t, kParts.size()> missed_by{};
  std::vector<double> slack_us;  ///< of each macro step, in their order
  std::vector<double> step_us;   ///< what each has taken

  [[nodiscard]] bool active() const { return factor > 0.0; }
};

/// Quantiles of the slack and of the time of a step, a histogram of the slack in parts of the wall
/// time that a macro step has, misses and whose they are.
[[nodiscard]] nlohmann::ordered_json to_json(const PaceReport& report, SimTime macro_step);

/// Holds a run to the wall clock: what happens at the simulated time t is due t/factor after the
/// run began. A macro step that is early waits, a late one is booked as a miss and the next begins
/// at once, so that a run that is fast enough catches up. It changes no bit of the results.
class Pace {
 public:
  /// `factor` 0: never waits, books nothing.
  explicit Pace(double factor);

  /// The run begins now.
  void begin();
  /// Waits for at most so many seconds, and throws where the run is to end meanwhile.
  using Rest = std::function<void(double seconds)>;
  /// The macro step to `time` has ended and has taken `step_s`, of which `ledger` names the parts;
  /// rests until it is due.
  void end_step(SimTime time, const Ledger& ledger, double step_s, const Rest& rest);

  [[nodiscard]] const PaceReport& report() const { return report_; }

 private:
  using Parts = std::array<double, PaceReport::kParts.size()>;

  [[nodiscard]] std::size_t slowest(const Parts& parts) const;

  PaceReport report_;
  double begin_s_ = 0.0, due_s_ = 0.0;  ///< of the run; of the last step
  std::size_t slow_part_ = 0;           ///< of the last step that took longer than it may
  Parts sums_s_{};                      ///< of all steps so far
};

}  // namespace tandem
