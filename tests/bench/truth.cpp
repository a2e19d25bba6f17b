// Compares monolithic runs with the reference trajectories of tests/data/coupled and draws them:
//   truth_plots [--out DIR]        (default: docs/figures of the source tree)
// writes truth_pendulum_beam.svg, truth_two_masses.svg and truth.txt.

#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "orchestrator/page/svg_plot.h"
#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"
#include "tests/support/truth_case.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::AxisScale;
using orchestrator::Plot;
using orchestrator::PlotSeries;

/// A case, its monolithic runs and their errors.
struct Comparison {
  TruthCase truth;
  Trajectory reference;
  ListedErrors listed;
  std::vector<double> steps_s;
  std::vector<Trajectory> runs;
  std::vector<std::map<std::string, double>> errors;
};

Comparison compare(const TruthCase& truth, const std::vector<double>& further_steps_s) {
  Comparison c{.truth = truth, .reference = reference_of(truth), .listed = listed_errors(truth)};
  c.steps_s = c.listed.steps_s;
  c.steps_s.insert(c.steps_s.end(), further_steps_s.begin(), further_steps_s.end());
  for (double h_s : c.steps_s) {
    c.runs.push_back(monolithic_trajectory(truth, h_s));
    c.errors.push_back(largest_errors(truth, c.runs.back(), c.reference));
  }
  return c;
}

std::vector<double> column(const Trajectory& trajectory, const std::string& name) {
  std::vector<double> values;
  const std::size_t i = trajectory.column(name);
  for (const std::vector<double>& row : trajectory.rows) values.push_back(row[i]);
  return values;
}

/// A column of the reference and of all runs over time.
Plot history(const Comparison& c, const std::string& name, const std::string& title,
             const std::string& y_label) {
  Plot plot{.title = title, .x_label = "t (s)", .y_label = y_label};
  plot.series.push_back(
      {.label = "reference", .x = column(c.reference, "t"), .y = column(c.reference, name)});
  for (std::size_t i = 0; i < c.runs.size(); ++i) {
    plot.series.push_back({.label = fmt::format("h = {:g} s", c.steps_s[i]),
                           .x = column(c.runs[i], "t"),
                           .y = column(c.runs[i], name),
                           .dashed = true});
  }
  return plot;
}

/// Largest error of a quantity over h, with the listed ones and a line of order 1.
Plot errors_over_step(const Comparison& c, const std::string& quantity, const std::string& title,
                      const std::string& y_label) {
  Plot plot{.title = title,
            .x_label = "h (s)",
            .y_label = y_label,
            .x_scale = AxisScale::Logarithmic,
            .y_scale = AxisScale::Logarithmic};
  PlotSeries ours{.label = "monolithic run", .markers = true};
  PlotSeries order{.label = "order 1", .dashed = true};
  for (std::size_t i = 0; i < c.steps_s.size(); ++i) {
    ours.x.push_back(c.steps_s[i]);
    ours.y.push_back(c.errors[i].at(quantity));
    order.x.push_back(c.steps_s[i]);
    order.y.push_back(1.3 * ours.y.front() * c.steps_s[i] / c.steps_s.front());
  }
  const PlotSeries listed{.label = "listed",
                          .x = c.listed.steps_s,
                          .y = c.listed.errors.at(quantity),
                          .markers = true,
                          .dashed = true};
  plot.series = {order, ours, listed};
  return plot;
}

std::string table(const Comparison& c) {
  std::string text =
      fmt::format("{}: largest error of the monolithic run (times the listed one)\n", c.truth.name);
  text += fmt::format("{:<12}", "h (s)");
  for (double h_s : c.steps_s) text += fmt::format("{:>20g}", h_s);
  text += "\n";
  for (const Quantity& quantity : c.truth.quantities) {
    text += fmt::format("{:<12}", quantity.name);
    for (std::size_t i = 0; i < c.steps_s.size(); ++i) {
      const double error = c.errors[i].at(quantity.name);
      const std::vector<double>& listed = c.listed.errors.at(quantity.name);
      const std::string factor =
          i < listed.size() ? fmt::format("({:.3f})", error / listed[i]) : std::string();
      text += fmt::format("{:>12.3e}{:>8}", error, factor);
    }
    text += "\n";
  }
  return text + "\n";
}

void draw(const std::filesystem::path& folder) {
  const Comparison beam = compare(pendulum_beam(), {});
  const Comparison damped = compare(pendulum_beam_damped(), {1.25e-4});
  const Comparison masses = compare(two_masses(), {1.25e-4});
  std::filesystem::create_directories(folder);
  write_whole_file(
      folder / "truth_pendulum_beam.svg",
      orchestrator::svg_document(
          {history(beam, "defl_n", "Undamped: tip deflection", "deflection along hub z (m)"),
           history(beam, "hub_Fz", "Undamped: force on the hub's nodes", "F z (N)"),
           history(damped, "defl_n", "Damped: tip deflection", "deflection along hub z (m)"),
           errors_over_step(damped, "tip_pos", "Damped: largest error of the tip position",
                            "error (m)")},
          2));
  write_whole_file(
      folder / "truth_two_masses.svg",
      orchestrator::svg_document(
          {history(masses, "distance", "Distance of the bodies", "distance (m)"),
           history(masses, "left_Fx", "Force on the left nodes", "F x (N)"),
           history(masses, "left_wz", "Angular velocity of the left body", "w z (rad/s)"),
           errors_over_step(masses, "distance", "Largest error of the distance", "error (m)")},
          2));
  const std::string text = table(beam) + table(damped) + table(masses);
  write_whole_file(folder / "truth.txt", text);
  std::fputs(text.c_str(), stdout);
}

int run(int argc, char** argv) {
  std::filesystem::path folder = std::filesystem::path(TANDEM_SOURCE_DIR) / "docs/figures";
  if (argc == 3 && std::string(argv[1]) == "--out") {
    folder = argv[2];
  } else if (argc != 1) {
    std::fputs("usage: truth_plots [--out DIR]\n", stderr);
    return 2;
  }
  try {
    draw(folder);
  } catch (const Error& error) {
    std::fprintf(stderr, "truth_plots: %s\n", error.what());
    return error.exit_code();
  }
  return 0;
}

}  // namespace
}  // namespace tandem::coupled_test

int main(int argc, char** argv) { return tandem::coupled_test::run(argc, argv); }
