#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "orchestrator/run/observed_run.h"
#include "orchestrator/scenario/model.h"

namespace tandem::orchestrator {

struct WorkPrecisionOptions {
  std::vector<std::string> schemes;  ///< empty = the scenario's own
  std::vector<double> steps_s;       ///< macro steps H to run
  std::vector<double> tolerances;    ///< of adaptive macro steps to run, from the smallest H on
  Mode mode = Mode::Lcm;             ///< how the schemes run: Lcm or Inproc
  std::int64_t repeat = 1;           ///< repetitions; the wall time is their median
  std::filesystem::path folder;      ///< holds the runs and the results
  double deadline_s = kNoDeadline;   ///< time of now_s() at which runs are broken off
};

/// One scheme at one macro step, or at one tolerance of adaptive steps.
struct PrecisionRow {
  std::string scheme;      ///< "monolithic" for the uncut system
  double step_s = 0.0;     ///< of adaptive steps their mean
  double tolerance = 0.0;  ///< coupling.adaptive.tolerance; 0 = all steps are equal
  int exit_code = 0;
  std::string status, message;
  MotionDistance error;  ///< of the port motion against the reference
  double wall_s = 0.0;
  std::int64_t macro_steps = 0;
  std::int64_t round_trips = 0;  ///< evaluations of the two sides, rejected ones too
  double iterations_mean = 0.0;
  double defect_max_J = 0.0, defect_sum_J = 0.0;  ///< interface energy defect
};

/// Work against precision: what each scheme's accuracy costs. The reference is the monolithic run
/// at an eighth of the smallest H; its own error is estimated by its distance from the monolithic
/// run at a quarter (for a method of first order the two are equal).
struct WorkPrecision {
  std::string scenario;
  std::string mode;
  double reference_step_s = 0.0;
  double reference_error_m = 0.0;
  double travel_m = 0.0;  ///< largest motion of a port from its start, see largest_travel_m
  std::vector<PrecisionRow> rows;
};

/// Runs the monolithic system at all steps and all schemes at all steps and tolerances. `load`
/// gives the model with a scheme ("" = the scenario's own), a macro step (s) and a tolerance of
/// adaptive steps (0 = fixed ones). A run that diverges is a row; a reference that is not solved is
/// a NotSolved error.
[[nodiscard]] WorkPrecision work_precision(
    const std::function<Model(const std::string& scheme, double step_s, double tolerance)>& load,
    const WorkPrecisionOptions& options);

[[nodiscard]] nlohmann::ordered_json work_precision_json(const WorkPrecision& result);
[[nodiscard]] std::string work_precision_csv(const WorkPrecision& result);
[[nodiscard]] std::string work_precision_table(const WorkPrecision& result);
/// Error over H and error over wall time, logarithmic.
[[nodiscard]] std::string work_precision_svg(const WorkPrecision& result);

}  // namespace tandem::orchestrator
