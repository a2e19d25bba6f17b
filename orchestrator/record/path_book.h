#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "orchestrator/record/critical_path.h"

namespace tandem::orchestrator {

/// Share (of 1) of each place, in the order of place_of(); all zero for a path of no length.
[[nodiscard]] std::vector<double> shares_of(const std::vector<PathPiece>& path,
                                            std::size_t workers);

/// "conrod 71 %, wire 9 %": the largest shares, those below 1 % left out.
[[nodiscard]] std::string largest_shares(const std::vector<double>& shares,
                                         const std::vector<std::string>& places,
                                         std::size_t most = 3);

/// What the critical paths of a run's macro steps add up to.
class PathBook {
 public:
  /// `here`: the workers that compute in the driver's process.
  PathBook(const std::vector<std::string>& workers, std::vector<bool> here);

  void add(std::int64_t macro_step, const StepTimes& step, const std::vector<PathPiece>& path);

  struct Prediction {
    std::size_t worker = 0;
    double twice_as_fast = 1.0;  ///< part of the run's time that it then takes
    double in_no_time = 1.0;     ///< what is left at best
  };
  /// The worker to speed up first comes first.
  [[nodiscard]] std::vector<Prediction> predictions() const;

  /// Names of workers and tolls, in the order of place_of().
  [[nodiscard]] const std::vector<std::string>& places() const { return places_; }
  [[nodiscard]] std::size_t workers() const { return here_.size(); }
  [[nodiscard]] std::int64_t steps() const { return steps_; }
  [[nodiscard]] double total_s() const { return total_s_; }
  [[nodiscard]] std::vector<double> shares() const;
  /// Share of what was rolled back later.
  [[nodiscard]] double discarded_share() const;

  /// Share of the time in which a process waited, by what the critical path was at meanwhile. Row 0
  /// is the driver's, row 1 + w that of worker w's own process; empty where it has none.
  [[nodiscard]] std::vector<std::vector<double>> waits() const;

  struct SlowStep {
    std::int64_t macro_step = 0;
    double duration_s = 0.0;
    std::vector<double> shares;
  };
  /// The slowest macro steps, slowest first.
  [[nodiscard]] const std::vector<SlowStep>& slowest() const { return slowest_; }
  /// Part of the macro steps in which this place has the largest share.
  [[nodiscard]] std::vector<double> led() const;

 private:
  void book_waits(const StepTimes& step, const std::vector<PathPiece>& path);

  std::vector<std::string> places_;
  std::vector<bool> here_;
  std::int64_t steps_ = 0;
  double total_s_ = 0.0, discarded_s_ = 0.0;
  std::vector<double> place_s_;
  std::vector<std::vector<double>> wait_s_;
  std::vector<double> half_s_, none_s_;  ///< run time with this worker twice as fast, in no time
  std::vector<std::int64_t> led_;
  std::vector<SlowStep> slowest_;
};

/// The book as text: shares, waits, what to speed up first, the slowest macro steps.
[[nodiscard]] std::string text_of(const PathBook& book, const std::string& driver);

}  // namespace tandem::orchestrator
