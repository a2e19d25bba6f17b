#include "orchestrator/page/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>

#include "orchestrator/files/csv_table.h"
#include "orchestrator/files/run_directory.h"
#include "orchestrator/files/summary_number.h"
#include "orchestrator/page/svg_plot.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kLargestCurve = 2000;  // more points than pixels show nothing more

constexpr const char* kStyle = R"(
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 1360px; padding: 0 1rem; color: #1a1a1a; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
table { border-collapse: collapse; } td, th { padding: .25rem .8rem; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; } .bad { color: #b03000; font-weight: 600; }
td.message { text-align: left; max-width: 50rem; } svg { max-width: 100%; height: auto; })";

struct ReportedRun {
  std::string label;
  ordered_json summary;
  CsvTable ports, steps;
  std::vector<std::string> remarks;  ///< of the tables
};

/// What the tables tell of a run that left no summary.
ordered_json summary_of(const RunDirectory& run, const CsvTable& steps) {
  const std::vector<double>& t_s = steps.column("t_s");
  const std::vector<double>& iterations = steps.column("iterations");
  const double rows = std::max(1.0, static_cast<double>(t_s.size()));
  return {
      {"scenario", std::filesystem::absolute(run.path()).filename().string()},
      {"status", "killed"},
      {"macro_steps", t_s.size()},
      {"simulated_s", t_s.empty() ? 0.0 : t_s.back()},
      {"iterations", {{"mean", std::accumulate(iterations.begin(), iterations.end(), 0.0) / rows}}},
      {"message",
       fmt::format("{}: missing or damaged: the recording process was killed. Shown is what "
                   "its tables hold.",
                   run.summary().string())}};
}

ReportedRun read_run(const std::filesystem::path& path, std::size_t number) {
  const RunDirectory run = RunDirectory::open(path);
  CsvTable ports(run.path() / "ports.csv");
  CsvTable steps(run.path() / "steps.csv");
  ordered_json summary = ordered_json::parse(std::ifstream(run.summary()), nullptr, false);
  if (summary.is_discarded()) summary = summary_of(run, steps);
  const std::string label =
      fmt::format("{}: {}", number,
                  summary.value("scheme", summary.value("mode", summary.value("status", ""))));
  std::vector<std::string> remarks;
  for (const CsvTable* table : {&ports, &steps}) {
    if (!table->remark().empty()) remarks.push_back(table->remark());
  }
  return {label, std::move(summary), std::move(ports), std::move(steps), std::move(remarks)};
}

/// Every n-th point of a curve that is longer than can be seen, and the last one.
PlotSeries thinned(const std::string& label, const std::vector<double>& x,
                   const std::vector<double>& y) {
  PlotSeries series{.label = label};
  const std::size_t every = 1 + x.size() / kLargestCurve;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (i % every != 0 && i + 1 != x.size()) continue;
    series.x.push_back(x[i]);
    series.y.push_back(y[i]);
  }
  return series;
}

/// |value − value at t = 0| (or |value|) of a vector with three columns.
std::vector<double> length_of(const CsvTable& table, const std::array<std::string, 3>& columns,
                              bool from_start) {
  std::vector<double> length(table.column(columns[0]).size(), 0.0);
  for (const std::string& name : columns) {
    const std::vector<double>& values = table.column(name);
    for (std::size_t i = 0; i < length.size(); ++i) {
      const double d = values[i] - (from_start ? values.front() : 0.0);
      length[i] = std::hypot(length[i], d);
    }
  }
  return length;
}

std::vector<std::string> ports_of(const CsvTable& table) {
  const std::string last = ".p_x_m";
  std::vector<std::string> ports;
  for (const std::string& name : table.names()) {
    if (name.ends_with(last)) ports.push_back(name.substr(0, name.size() - last.size()));
  }
  return ports;
}

std::string port_plots(const std::vector<ReportedRun>& runs, const std::string& port) {
  Plot path{.title = port + ": way of the port", .x_label = "t (s)", .y_label = "|p − p(0)| (m)"};
  Plot force{.title = port + ": force", .x_label = "t (s)", .y_label = "|f| (N)"};
  for (const ReportedRun& run : runs) {
    if (!run.ports.has(port + ".p_x_m")) continue;
    const std::vector<double>& t = run.ports.column("t_s");
    path.series.push_back(
        thinned(run.label, t,
                length_of(run.ports, {port + ".p_x_m", port + ".p_y_m", port + ".p_z_m"}, true)));
    force.series.push_back(
        thinned(run.label, t,
                length_of(run.ports, {port + ".f_x_N", port + ".f_y_N", port + ".f_z_N"}, false)));
  }
  return svg_document({path, force}, 2);
}

std::string step_plots(const std::vector<ReportedRun>& runs) {
  Plot iterations{
      .title = "evaluations per macro step", .x_label = "t (s)", .y_label = "evaluations"};
  Plot defect{.title = "interface energy defect of a macro step",
              .x_label = "t (s)",
              .y_label = "|δE| (J)",
              .y_scale = AxisScale::Logarithmic};
  for (const ReportedRun& run : runs) {
    const std::vector<double>& t = run.steps.column("t_s");
    iterations.series.push_back(thinned(run.label, t, run.steps.column("iterations")));
    std::vector<double> size = run.steps.column("energy_defect_J");
    for (double& value : size) value = std::abs(value);
    defect.series.push_back(thinned(run.label, t, size));
  }
  return svg_document({iterations, defect}, 2);
}

/// What bounds the run's accuracy, a line each, and the numbers of its books.
std::string verdict_row(const ordered_json& verdict) {
  std::string text = "Verdict: " + escaped(verdict.value("status", "")) + ".";
  for (const ordered_json& cause : verdict.value("causes", ordered_json::array())) {
    text += fmt::format("<br>{}: {}", escaped(cause.value("text", "")),
                        escaped(cause.value("remedy", "")));
  }
  return fmt::format("<tr><td></td><td class=\"message\" colspan=\"10\">{}<br>{}</td></tr>\n", text,
                     escaped(verdict.value("numbers", "")));
}

std::string summary_table(const std::vector<ReportedRun>& runs) {
  std::string html =
      "<table><tr><th>run</th><th>scenario</th><th>mode</th><th>status</th><th>macro steps</th>"
      "<th>simulated s</th><th>wall s</th><th>real time</th><th>evaluations / step</th>"
      "<th>Σ δE (J)</th><th>final state</th></tr>\n";
  for (const ReportedRun& run : runs) {
    const ordered_json& s = run.summary;
    const ordered_json none = ordered_json::object();
    const ordered_json verdict = s.value("verdict", none);
    // Runs of earlier versions have a status alone.
    const std::string status = verdict.value("status", s.value("status", ""));
    fmt::format_to(std::back_inserter(html),
                   "<tr><td>{}</td><td>{}</td><td>{}</td><td{}>{}</td><td>{}</td><td>{:g}</td>"
                   "<td>{:.3f}</td><td>{:.3f}</td><td>{:.2f}</td><td>{:.2e}</td><td>{}</td></tr>\n",
                   escaped(run.label), escaped(s.value("scenario", "")), s.value("mode", ""),
                   status == "done" ? "" : " class=\"bad\"", escaped(status),
                   s.value("macro_steps", std::int64_t{0}), s.value("simulated_s", 0.0),
                   s.value("wall_s", 0.0), s.value("realtime_ratio", 0.0),
                   s.value("iterations", none).value("mean", 0.0),
                   number_at(s.value("energy_J", none), "interface_defect_sum"),
                   s.value("state_hash", ""));
    if (verdict.contains("text")) html += verdict_row(verdict);
    std::string message = s.value("message", "");
    for (const std::string& remark : run.remarks) message += (message.empty() ? "" : " ") + remark;
    if (!message.empty()) {
      fmt::format_to(std::back_inserter(html),
                     "<tr><td></td><td class=\"message\" colspan=\"10\">{}</td></tr>\n",
                     escaped(message));
    }
  }
  return html + "</table>\n";
}

std::string ledger_table(const std::vector<ReportedRun>& runs) {
  std::string html = "<table><tr><th>µs per macro step</th>";
  for (const ReportedRun& run : runs) html += "<th>" + escaped(run.label) + "</th>";
  html += "</tr>\n";
  const ordered_json none = ordered_json::object();
  const ordered_json ledger = runs.front().summary.value("ledger_s", none);
  for (const auto& [column, unused] : ledger.items()) {
    html += "<tr><td>" + column + "</td>";
    for (const ReportedRun& run : runs) {
      const double steps = std::max(1.0, run.summary.value("macro_steps", 0.0));
      fmt::format_to(std::back_inserter(html), "<td>{:.2f}</td>",
                     1e6 * run.summary.value("ledger_s", none).value(column, 0.0) / steps);
    }
    html += "</tr>\n";
  }
  return html +
         "</table>\n<p>discarded: computing that was rolled back, part of the two compute "
         "rows.</p>\n";
}

}  // namespace

ReportPage report_page(const std::vector<std::filesystem::path>& folders) {
  std::vector<ReportedRun> runs;
  for (const auto& folder : folders) runs.push_back(read_run(folder, runs.size() + 1));
  const std::string title = "Tandem: " + escaped(runs.front().summary.value("scenario", "runs"));
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>{}</title><style>{}</style></head><body>\n"
      "<h1>{}</h1>\n{}<h2>Where the time went</h2>\n{}",
      title, kStyle, title, summary_table(runs), ledger_table(runs));
  for (const std::string& port : ports_of(runs.front().ports)) {
    html += "<h2>Port " + escaped(port) + "</h2>\n" + port_plots(runs, port);
  }
  html += "<h2>Coupling</h2>\n" + step_plots(runs) + "<p>Run folders:</p><ol>\n";
  for (const auto& folder : folders) html += "<li>" + escaped(folder.string()) + "</li>\n";
  ReportPage page{.html = html + "</ol></body></html>\n", .remarks = {}};
  for (const ReportedRun& run : runs) {
    if (run.summary.value("status", "") == "killed") {
      page.remarks.push_back(run.summary.value("message", ""));
    }
    page.remarks.insert(page.remarks.end(), run.remarks.begin(), run.remarks.end());
  }
  return page;
}

}  // namespace tandem::orchestrator
