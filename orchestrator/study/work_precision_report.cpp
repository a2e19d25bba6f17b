#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "orchestrator/page/svg_plot.h"
#include "orchestrator/study/work_precision.h"

namespace tandem::orchestrator {
namespace {

using nlohmann::ordered_json;

ordered_json row_json(const PrecisionRow& row) {
  return {{"scheme", row.scheme},
          {"macro_step_s", row.step_s},
          {"adaptive_tolerance", row.tolerance},
          {"status", row.status},
          {"message", row.message},
          {"error_motion_m", row.error.motion_m},
          {"error_max_m", row.error.max_m},
          {"error_rms_m", row.error.rms_m},
          {"error_max_rad", row.error.max_rad},
          {"wall_s", row.wall_s},
          {"macro_steps", row.macro_steps},
          {"round_trips", row.round_trips},
          {"iterations_mean", row.iterations_mean},
          {"interface_defect_max_J", row.defect_max_J},
          {"interface_defect_sum_J", row.defect_sum_J}};
}

std::string label_of(const PrecisionRow& row) {
  return row.tolerance > 0.0 ? row.scheme + ", adaptive" : row.scheme;
}

/// H, or the mean of adaptive steps and their tolerance.
std::string step_text(const PrecisionRow& row) {
  if (row.tolerance == 0.0) return fmt::format("{}", row.step_s);
  return fmt::format("~{:.2g} ({:g})", row.step_s, row.tolerance);
}

/// One curve per scheme, and one for its adaptive steps, through the runs that were solved.
Plot error_plot(const WorkPrecision& result, const std::string& x_label,
                double (*x_of)(const PrecisionRow&)) {
  Plot plot{.title = result.scenario,
            .x_label = x_label,
            .y_label = "error of port motion (m)",
            .x_scale = AxisScale::Logarithmic,
            .y_scale = AxisScale::Logarithmic};
  std::string scheme_before;
  for (const PrecisionRow& row : result.rows) {
    if (row.exit_code != 0) continue;
    if (plot.series.empty() || plot.series.back().label != label_of(row)) {
      const bool adaptive = row.tolerance > 0.0;
      plot.series.push_back({.label = label_of(row),
                             .markers = true,
                             .dashed = adaptive,
                             .as_before = adaptive && row.scheme == scheme_before});
      scheme_before = row.scheme;
    }
    plot.series.back().x.push_back(x_of(row));
    plot.series.back().y.push_back(row.error.motion_m);
  }
  return plot;
}

}  // namespace

ordered_json work_precision_json(const WorkPrecision& result) {
  ordered_json json = {{"scenario", result.scenario},
                       {"mode", result.mode},
                       {"reference",
                        {{"scheme", "monolithic"},
                         {"macro_step_s", result.reference_step_s},
                         {"error_estimate_m", result.reference_error_m}}},
                       {"largest_travel_m", result.travel_m},
                       {"rows", ordered_json::array()}};
  for (const PrecisionRow& row : result.rows) json["rows"].push_back(row_json(row));
  return json;
}

std::string work_precision_csv(const WorkPrecision& result) {
  std::string csv =
      "scheme,macro_step_s,adaptive_tolerance,status,error_motion_m,error_max_m,error_rms_m,error_"
      "max_rad,wall_s,"
      "macro_steps,"
      "round_trips,iterations_mean,interface_defect_max_J,interface_defect_sum_J\n";
  for (const PrecisionRow& row : result.rows) {
    fmt::format_to(std::back_inserter(csv), "{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
                   row.scheme, row.step_s, row.tolerance, row.status, row.error.motion_m,
                   row.error.max_m, row.error.rms_m, row.error.max_rad, row.wall_s, row.macro_steps,
                   row.round_trips, row.iterations_mean, row.defect_max_J, row.defect_sum_J);
  }
  return csv;
}

namespace {

std::string adaptive_line(const WorkPrecision& result) {
  const bool any =
      std::ranges::any_of(result.rows, [](const auto& r) { return r.tolerance > 0.0; });
  return any ? "Of adaptive steps, H is the mean and in brackets coupling.adaptive.tolerance.\n"
             : "";
}

}  // namespace

std::string work_precision_table(const WorkPrecision& result) {
  std::string table = fmt::format(
      "{}: error of the port motion against the monolithic run at H = {} s (whose own error is\n"
      "about {:.1e} m), work in mode {}. Motion: |Δp| + port length × rotation; the ports travel "
      "{:.3g} m.\n{}\n"
      "{:<20} {:>16} {:>11} {:>11} {:>10} {:>9} {:>11} {:>10} {:>11}\n",
      result.scenario, result.reference_step_s, result.reference_error_m, result.mode,
      result.travel_m, adaptive_line(result), "scheme", "H s", "motion m", "rms |Δp| m", "max rad",
      "wall s", "round trips", "iterations", "defect J");
  std::string messages;
  for (const PrecisionRow& row : result.rows) {
    if (row.exit_code != 0) {
      fmt::format_to(std::back_inserter(table), "{:<20} {:>16} {}, see below\n", row.scheme,
                     step_text(row), row.status);
      fmt::format_to(std::back_inserter(messages), "\n{}, H = {} s: {}\n", row.scheme,
                     step_text(row), row.message);
      continue;
    }
    fmt::format_to(
        std::back_inserter(table),
        "{:<20} {:>16} {:>11.3e} {:>11.3e} {:>10.2e} {:>9.3f} {:>11} {:>10.2f} {:>11.2e}\n",
        row.scheme, step_text(row), row.error.motion_m, row.error.rms_m, row.error.max_rad,
        row.wall_s, row.round_trips, row.iterations_mean, row.defect_sum_J);
  }
  return table + messages;
}

std::string work_precision_svg(const WorkPrecision& result) {
  return svg_document(
      {error_plot(result, "macro step H (s)", [](const PrecisionRow& row) { return row.step_s; }),
       error_plot(result, "wall time (s)", [](const PrecisionRow& row) { return row.wall_s; })},
      2);
}

}  // namespace tandem::orchestrator
