#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "orchestrator/run/observed_run.h"
#include "orchestrator/run/run.h"
#include "orchestrator/scenario/model.h"

namespace tandem::orchestrator {

struct CompareOptions {
  std::int64_t repeat = 3;           ///< interleaved repetitions of every run
  std::vector<std::string> schemes;  ///< empty = the scenario's own
  std::filesystem::path folder;      ///< holds <scheme>/<mode>-<repetition>/ and compare.json
};

/// One way of running the scenario, repeated.
struct ComparedRuns {
  Mode mode = Mode::Lcm;
  std::string scheme;
  int exit_code = 0;
  std::vector<double> wall_s;                     ///< one per repetition
  std::vector<nlohmann::ordered_json> summaries;  ///< one per repetition
  nlohmann::ordered_json summary;  ///< of the repetition whose wall time is the median
  History history;                 ///< of the last repetition
};

/// What a comparison found. The first entry of `runs` is the monolithic run, then in-process and
/// LCM for each scheme.
struct Comparison {
  std::string scenario;
  std::int64_t repeat = 0;
  std::vector<ComparedRuns> runs;

  [[nodiscard]] const ComparedRuns& find(Mode mode, const std::string& scheme) const;
};

/// Runs monolithic, in-process and LCM of the same scenario in turn (A B C A B C …), so that a
/// drift of the machine's speed meets all of them alike. `load` gives the model with a scheme.
[[nodiscard]] Comparison compare(const std::function<Model(const std::string& scheme)>& load,
                                 const CompareOptions& options);

/// Of one number per interleaved repetition: median, least, greatest. With n repetitions the true
/// median lies outside of [min, max] with a probability of 2^(1 − n).
struct Spread {
  double median = 0.0, min = 0.0, max = 0.0;
  std::size_t repetitions = 0;
  /// Whether all repetitions agree that the number is not `value`; a single one tells nothing.
  [[nodiscard]] bool differs_from(double value) const {
    return repetitions > 1 && (min > value || max < value);
  }
};
[[nodiscard]] Spread spread_of(std::vector<double> values);
/// Ratio of wall times a/b, repetition by repetition.
[[nodiscard]] Spread ratio(const ComparedRuns& a, const ComparedRuns& b);
/// What a macro step over LCM takes longer than in process, repetition by repetition (µs).
[[nodiscard]] Spread transfer_us_per_step(const ComparedRuns& lcm, const ComparedRuns& inproc);
/// What the ledger of the median repetition over LCM books as transfer and synchronisation, i.e.
/// encode, decode, publish, transit and wait (µs per macro step).
[[nodiscard]] double booked_transfer_us(const ComparedRuns& lcm);
/// The price of co-simulation in words, for the table: intervals, or that they are not resolved.
[[nodiscard]] std::string price_text(const std::string& scheme, const ComparedRuns& mono,
                                     const ComparedRuns& inproc, const ComparedRuns& lcm);
[[nodiscard]] double median(std::vector<double> values);

/// Largest |p_WP| distance (m) between two runs over all macro steps and ports that both have.
[[nodiscard]] double largest_distance_m(const ComparedRuns& a, const ComparedRuns& b);

/// Largest difference of any port component (SI units of the component); 0 = the same bits.
[[nodiscard]] double largest_difference(const ComparedRuns& a, const ComparedRuns& b);

/// compare.json, and the table that is printed.
[[nodiscard]] nlohmann::ordered_json compare_json(const Comparison& comparison);
[[nodiscard]] std::string compare_table(const Comparison& comparison);

}  // namespace tandem::orchestrator
