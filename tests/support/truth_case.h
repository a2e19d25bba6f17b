#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {

/// Named columns over time, as in the reference files; the first column is t (s).
struct Trajectory {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
  [[nodiscard]] std::size_t column(const std::string& name) const;
};
[[nodiscard]] Trajectory read_trajectory(const std::filesystem::path& file);

/// A quantity of the error tables: one column, or the components of a vector.
struct Quantity {
  std::string name;
  std::vector<std::string> columns;
  bool is_quaternion = false;  ///< q and −q are one rotation
};

/// A coupled case with a reference trajectory under tests/data/coupled.
struct TruthCase {
  std::string name;      ///< as in first_order_errors.csv, and of its reference file
  std::string scenario;  ///< below examples/
  CoupledPair::Overrides overrides;
  std::vector<Quantity> quantities;
};
[[nodiscard]] TruthCase pendulum_beam();
[[nodiscard]] TruthCase pendulum_beam_damped();
[[nodiscard]] TruthCase two_masses();

[[nodiscard]] Trajectory reference_of(const TruthCase& truth);

/// The monolithic run of the case with macro step h (s), sampled at the reference's times; throws
/// when the run does not end as Done.
[[nodiscard]] Trajectory monolithic_trajectory(const TruthCase& truth, double h_s);

/// The same of any run of the case, against `reference`, which may be only the beginning of the
/// case's own.
[[nodiscard]] Trajectory trajectory(const TruthCase& truth, double h_s, orchestrator::Mode mode,
                                    const Trajectory& reference);

/// The rows with t <= end_s.
[[nodiscard]] Trajectory beginning_of(Trajectory trajectory, double end_s);

/// Largest norm of the difference over all samples after t = 0, by quantity. At t = 0 both are the
/// same given state, but for the wrench, which then belongs to no step.
[[nodiscard]] std::map<std::string, double> largest_errors(const TruthCase& truth,
                                                           const Trajectory& run,
                                                           const Trajectory& reference);

/// The steps (s) and errors listed for a first-order scheme: errors[quantity][i] at steps[i].
struct ListedErrors {
  std::vector<double> steps_s;
  std::map<std::string, std::vector<double>> errors;
};
[[nodiscard]] ListedErrors listed_errors(const TruthCase& truth);

}  // namespace tandem::coupled_test
