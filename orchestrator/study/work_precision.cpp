#include "orchestrator/study/work_precision.h"

#include <fmt/format.h>

#include <algorithm>

#include "orchestrator/files/summary_number.h"
#include "orchestrator/study/compare.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

constexpr int kReferenceRefinement = 8;

ObservedRun reference_run(const Model& model, const WorkPrecisionOptions& options) {
  const double step_s = to_seconds(model.run.macro_step);
  ObservedRun run =
      observe_run(model, Mode::Monolithic, options.folder / "reference" / fmt::format("{}", step_s),
                  fmt::format("reference: monolithic, H = {} s", step_s), options.deadline_s);
  if (run.exit_code != 0) {
    throw Error(ErrorKind::NotSolved,
                fmt::format("compare --steps: the reference, the monolithic run at H = {} s, was "
                            "not solved: {}",
                            step_s, run.summary.at("message").get<std::string>()));
  }
  return run;
}

/// What all runs are compared with.
struct Reference {
  History history;
  std::vector<PortInfo> ports;
};

/// One scheme at one step, `repeat` times.
PrecisionRow measure(const Model& model, const std::string& scheme, Mode mode,
                     const WorkPrecisionOptions& options, const Reference& reference) {
  const double tolerance = mode == Mode::Monolithic ? 0.0 : model.coupling.adaptive.tolerance;
  PrecisionRow row{
      .scheme = scheme, .step_s = to_seconds(model.run.macro_step), .tolerance = tolerance};
  const std::string length =
      tolerance > 0.0 ? fmt::format("adaptive {}", tolerance) : fmt::format("H = {} s", row.step_s);
  const std::string name =
      tolerance > 0.0 ? fmt::format("adaptive-{}", tolerance) : fmt::format("{}", row.step_s);
  std::vector<double> wall_s;
  double simulated_s = 0.0;
  for (std::int64_t repetition = 1; repetition <= options.repeat; ++repetition) {
    const ObservedRun run =
        observe_run(model, mode, options.folder / scheme / fmt::format("{}-{}", name, repetition),
                    fmt::format("{}, {}, {} of {}", scheme, length, repetition, options.repeat),
                    options.deadline_s);
    const auto& s = run.summary;
    row.exit_code = run.exit_code;
    row.status = s.at("status").get<std::string>();
    row.message = s.at("message").get<std::string>();
    row.error = motion_distance(run.history, reference.history, reference.ports);
    simulated_s = s.at("simulated_s").get<double>();
    row.macro_steps = s.at("macro_steps").get<std::int64_t>();
    row.round_trips = s.at("iterations").at("total").get<std::int64_t>();
    row.iterations_mean = s.at("iterations").at("mean").get<double>();
    row.defect_max_J = number_at(s.at("energy_J"), "interface_defect_max");
    row.defect_sum_J = number_at(s.at("energy_J"), "interface_defect_sum");
    wall_s.push_back(s.at("wall_s").get<double>());
  }
  row.wall_s = median(wall_s);
  if (tolerance > 0.0 && row.macro_steps > 0) {
    row.step_s = simulated_s / static_cast<double>(row.macro_steps);
  }
  return row;
}

/// Equal runs would share a folder.
template <class T>
void require_each_once(const char* option, const std::vector<T>& values) {
  for (const T& value : values) {
    require(std::count(values.begin(), values.end(), value) == 1,
            fmt::format("{}: {} is named twice. Name it once.", option, value));
  }
}

}  // namespace

WorkPrecision work_precision(
    const std::function<Model(const std::string& scheme, double step_s, double tolerance)>& load,
    const WorkPrecisionOptions& options) {
  require_each_once("--schemes", options.schemes);
  require_each_once("--steps", options.steps_s);
  require_each_once("--tolerances", options.tolerances);
  std::vector<std::string> schemes = options.schemes;
  if (schemes.empty()) schemes.push_back("");
  const double least_s = *std::min_element(options.steps_s.begin(), options.steps_s.end());
  // Every model is made before the first run: a step that does not divide the duration is said now.
  std::vector<Model> models;
  for (const std::string& scheme : schemes) {
    for (const double step_s : options.steps_s) models.push_back(load(scheme, step_s, 0.0));
    for (const double tolerance : options.tolerances) {
      models.push_back(load(scheme, least_s, tolerance));
    }
  }
  const Model fine = load("", least_s / kReferenceRefinement, 0.0);
  const Model half = load("", 2.0 * least_s / kReferenceRefinement, 0.0);

  const Reference reference{.history = reference_run(fine, options).history,
                            .ports = make_fem(fine, {})->info().ports};
  WorkPrecision result{.scenario = fine.name,
                       .mode = to_string(options.mode),
                       .reference_step_s = to_seconds(fine.run.macro_step),
                       .reference_error_m = motion_distance(reference_run(half, options).history,
                                                            reference.history, reference.ports)
                                                .motion_m,
                       .travel_m = largest_travel_m(reference.history, reference.ports)};
  for (std::size_t i = 0; i < options.steps_s.size(); ++i) {
    result.rows.push_back(measure(models[i], "monolithic", Mode::Monolithic, options, reference));
  }
  for (const Model& model : models) {
    result.rows.push_back(
        measure(model, to_string(model.coupling.scheme), options.mode, options, reference));
  }
  return result;
}

}  // namespace tandem::orchestrator
