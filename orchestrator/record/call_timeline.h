#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "orchestrator/record/clock_fit.h"
#include "orchestrator/record/critical_path.h"
#include "protocol/wire/journal.h"

namespace tandem::orchestrator {

/// From the call times of a log to macro steps on the driver's clock. The first workers are the
/// multibody worlds, the others the flexible bodies, in their order.
class CallTimeline {
 public:
  /// Names of the flexible bodies and of the worlds; a single one may have none.
  explicit CallTimeline(const std::vector<std::string>& bodies,
                        const std::vector<std::string>& worlds = {""});

  /// First pass over the log: what its exchanges say of the other processes' clocks.
  void learn(const wire::StepJournal& journal);
  void fit();

  /// Second pass. `next`: the macro step behind this one, where the log has it.
  [[nodiscard]] StepTimes step(const wire::StepJournal& journal,
                               const wire::StepJournal* next) const;

  /// The errands of one call.
  [[nodiscard]] std::vector<Errand> errands(const wire::CallRecord& call) const;

  [[nodiscard]] const std::vector<std::string>& workers() const { return names_; }
  /// "tandem-mbs", "tandem-fem", "tandem-fem conrod"; of a single world without its name.
  [[nodiscard]] std::string program_of(std::size_t worker) const;
  /// Whether the worker computed in the driver's process; of the calls learned.
  [[nodiscard]] bool is_here(std::size_t worker) const { return clocks_[worker].bounds.empty(); }
  [[nodiscard]] const ClockFit& clock(std::size_t worker) const { return clocks_[worker].fit; }
  /// Of the calls learned: there is one without times.
  [[nodiscard]] bool lacks_times() const { return lacks_times_; }
  /// Begin of the first call learned.
  [[nodiscard]] double origin_s() const { return origin_s_.value_or(0.0); }

 private:
  struct Clock {
    double origin_us = 0.0;  ///< small differences keep their digits
    std::vector<OffsetBounds> bounds;
    ClockFit fit;
  };
  [[nodiscard]] std::size_t worker_of(const wire::CallRecord& call, std::size_t part) const;
  [[nodiscard]] static OffsetBounds bounds_of(const wire::PartTimes& part, double origin_us);

  /// Of the workers of a kind: the first one, and behind the last.
  struct Range {
    std::size_t begin = 0, end = 0;
    [[nodiscard]] std::size_t size() const { return end - begin; }
  };
  [[nodiscard]] Range workers_of(wire::SideName side) const;

  std::vector<std::string> names_;
  std::size_t worlds_;
  std::vector<Clock> clocks_;
  std::optional<double> origin_s_;
  bool lacks_times_ = false;
};

}  // namespace tandem::orchestrator
