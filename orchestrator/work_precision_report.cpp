#include <fmt/format.h>

#include <iterator>

#include "orchestrator/svg_plot.h"
#include "orchestrator/work_precision.h"

namespace tandem::orchestrator {
namespace {

using nlohmann::ordered_json;

ordered_json row_json(const PrecisionRow& row) {
  return {{"scheme", row.scheme},
          {"macro_step_s", row.step_s},
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

/// One curve per scheme through the runs that were solved.
Plot error_plot(const WorkPrecision& result, const std::string& x_label,
                double (*x_of)(const PrecisionRow&)) {
  Plot plot{.title = result.scenario,
            .x_label = x_label,
            .y_label = "error of port motion (m)",
            .x_scale = AxisScale::Logarithmic,
            .y_scale = AxisScale::Logarithmic};
  for (const PrecisionRow& row : result.rows) {
    if (row.exit_code != 0) continue;
    if (plot.series.empty() || plot.series.back().label != row.scheme) {
      plot.series.push_back({.label = row.scheme, .markers = true});
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
      "scheme,macro_step_s,status,error_motion_m,error_max_m,error_rms_m,error_max_rad,wall_s,"
      "macro_steps,"
      "round_trips,iterations_mean,interface_defect_max_J,interface_defect_sum_J\n";
  for (const PrecisionRow& row : result.rows) {
    fmt::format_to(std::back_inserter(csv), "{},{},{},{},{},{},{},{},{},{},{},{},{}\n", row.scheme,
                   row.step_s, row.status, row.error.motion_m, row.error.max_m, row.error.rms_m,
                   row.error.max_rad, row.wall_s, row.macro_steps, row.round_trips,
                   row.iterations_mean, row.defect_max_J, row.defect_sum_J);
  }
  return csv;
}

std::string work_precision_table(const WorkPrecision& result) {
  std::string table = fmt::format(
      "{}: error of the port motion against the monolithic run at H = {} s (whose own error is\n"
      "about {:.1e} m), work in mode {}. Motion: |Δp| + port length × rotation; the ports travel "
      "{:.3g} m.\n\n"
      "{:<20} {:>10} {:>11} {:>11} {:>10} {:>9} {:>11} {:>10} {:>11}\n",
      result.scenario, result.reference_step_s, result.reference_error_m, result.mode,
      result.travel_m, "scheme", "H s", "motion m", "rms |Δp| m", "max rad", "wall s",
      "round trips", "iterations", "defect J");
  std::string messages;
  for (const PrecisionRow& row : result.rows) {
    if (row.exit_code != 0) {
      fmt::format_to(std::back_inserter(table), "{:<20} {:>10} {}, see below\n", row.scheme,
                     row.step_s, row.status);
      fmt::format_to(std::back_inserter(messages), "\n{}, H = {} s: {}\n", row.scheme, row.step_s,
                     row.message);
      continue;
    }
    fmt::format_to(
        std::back_inserter(table),
        "{:<20} {:>10} {:>11.3e} {:>11.3e} {:>10.2e} {:>9.3f} {:>11} {:>10.2f} {:>11.2e}\n",
        row.scheme, row.step_s, row.error.motion_m, row.error.rms_m, row.error.max_rad, row.wall_s,
        row.round_trips, row.iterations_mean, row.defect_sum_J);
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
