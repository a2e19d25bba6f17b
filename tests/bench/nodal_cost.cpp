// What it costs to let every node of a mesh be a body of the multibody side: time and bytes per
// step of bars of growing length, clamped at one end, coupled node by node and through one rigid
// port at the other end, in one process and over LCM.
//   nodal_cost SVG_FILE      writes the plot, prints the table of docs/nodal.md

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "orchestrator/run.h"
#include "orchestrator/svg_plot.h"
#include "protocol/contract/error.h"
#include "tests/support/fem_box.h"

namespace tandem::orchestrator {
namespace {

constexpr int kSteps = 200;
constexpr int kRepetitions = 3;

/// A bar of n cubes of 0.1 m: 4 n free nodes, 6 n tetrahedra.
std::string scenario_text(int n, bool nodal) {
  std::string text = fmt::format(
      "name: bar_{0}\nrun: {{duration_s: {1}, macro_step_s: 0.001}}\n"
      "coupling: {{scheme: explicit_serial, prediction: hold}}\n"
      "fem:\n  mesh: {{file: bar_{0}.inp, length_scale_m: 0.1}}\n"
      "  material: {{young_Pa: 1.0e+6, poisson: 0.3, density_kg_per_m3: 1000}}\n"
      "  mass: lumped\n  fixed: [LEFT]\n"
      "  loads: [{{kind: nodal, set: ALL, force_N: [0, 0, 0.1]}}]\n",
      n, 1e-3 * kSteps);
  if (nodal) return text + "  coupling: nodal\nmbs: {gravity_m_per_s2: [0, 0, 0]}\n";
  return text + fmt::format(
                    "ports: [{{name: end, body: block, node_set: RIGHT}}]\n"
                    "mbs:\n  gravity_m_per_s2: [0, 0, 0]\n  bodies: [{{name: block, mass_kg: 100, "
                    "inertia_kg_m2: [1, 1, 1], position_m: [{}, 0.05, 0.05]}}]\n",
                    0.1 * n);
}

struct Cost {
  double step_us = 0.0;
  double bytes = 0.0;
};

/// Median of the repetitions.
Cost cost_of(const std::filesystem::path& folder, int n, bool nodal, Mode mode) {
  const std::filesystem::path file = folder / fmt::format("bar_{}_{}.yaml", n, nodal);
  std::ofstream(file) << scenario_text(n, nodal);
  const Model model = load_model(file, {});
  std::vector<double> times;
  double bytes = 0.0;
  for (int i = 0; i < kRepetitions; ++i) {
    const std::filesystem::path run = folder / "run";
    std::filesystem::remove_all(run);
    const RunOutcome outcome = run_model(model, RunDirectory::create(run, model.name),
                                         {.mode = mode, .silent = true, .watch = {}});
    require(outcome.exit_code == 0, outcome.summary.value("message", std::string("no message")));
    times.push_back(1e6 * outcome.summary.at("wall_s").get<double>() / kSteps);
    bytes = outcome.summary.at("wire").at("bytes").get<double>() / kSteps;
  }
  std::sort(times.begin(), times.end());
  return {times[kRepetitions / 2], bytes};
}

void run(const std::string& svg_file) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "tandem_nodal_cost";
  std::filesystem::create_directories(folder);
  std::vector<PlotSeries> series;
  for (const char* label :
       {"nodal, LCM", "nodal, one process", "rigid port, LCM", "rigid port, one proc."}) {
    series.push_back({.label = label, .x = {}, .y = {}, .markers = true});
  }
  fmt::print(
      "| free nodes | nodal, LCM (µs per step) | nodal, one process | rigid port, LCM | rigid "
      "port, "
      "one process | nodal, LCM (bytes per step) | rigid port, LCM "
      "|\n|---|---|---|---|---|---|---|\n");
  for (int n : {3, 8, 25, 75, 125}) {
    std::ofstream(folder / fmt::format("bar_{}.inp", n)) << fem::testing::box_inp(n);
    Cost costs[4];
    for (int kind = 0; kind < 4; ++kind) {
      costs[kind] = cost_of(folder, n, kind < 2, kind % 2 == 0 ? Mode::Lcm : Mode::Inproc);
      series[static_cast<std::size_t>(kind)].x.push_back(4 * n);
      series[static_cast<std::size_t>(kind)].y.push_back(costs[kind].step_us);
    }
    fmt::print("| {} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.0f} |\n", 4 * n,
               costs[0].step_us, costs[1].step_us, costs[2].step_us, costs[3].step_us,
               costs[0].bytes, costs[2].bytes);
    std::fflush(stdout);
  }
  std::filesystem::remove_all(folder);
  std::ofstream(svg_file) << svg_document({Plot{.title = "Every node in the multibody side",
                                                .x_label = "free nodes",
                                                .y_label = "time per step (µs)",
                                                .x_scale = AxisScale::Logarithmic,
                                                .y_scale = AxisScale::Logarithmic,
                                                .series = std::move(series)}});
}

}  // namespace
}  // namespace tandem::orchestrator

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: nodal_cost SVG_FILE\n");
    return 2;
  }
  try {
    tandem::orchestrator::run(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "nodal_cost: %s\n", error.what());
    return 4;
  }
  return 0;
}
