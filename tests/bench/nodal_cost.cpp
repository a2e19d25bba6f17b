// What it costs to let every node of a mesh be a body of the multibody side: time and bytes per
// step of the same bar in ever finer meshes, clamped at one end, coupled node by node and through
// one rigid port at the other end, in one process and over LCM.
//   nodal_cost SVG_FILE      writes the plot, prints the tables of docs/nodal.md

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "fem_process/keys/fem_keys.h"
#include "fem_process/reduced/highest_frequency.h"
#include "orchestrator/page/svg_plot.h"
#include "orchestrator/run/run.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

constexpr int kRepetitions = 5;
/// The macro step of the port coupling, which is implicit inside the flexible body: accuracy of the
/// first bending, 10 Hz, limits it.
constexpr double kPortStep_s = 5e-3;
/// Speed of sound of steel over that of the bar: the step that is stable is so much shorter, what a
/// step costs is the same.
const double kSteel = std::sqrt((2.1e11 / 7800.0) / (1e6 / 1000.0));

/// Abaqus text of a bar of 3 m × m × m cubes, six tets each (Kuhn's division), 0.3 m long.
std::string bar_inp(int m) {
  const int length = 3 * m;
  const auto tag = [m](int x, int y, int z) { return 1 + (x * (m + 1) + y) * (m + 1) + z; };
  std::string nodes = "*NODE\n";
  std::string left = "*NSET, NSET=LEFT\n";
  std::string right = "*NSET, NSET=RIGHT\n";
  std::string tets = "*ELEMENT, TYPE=C3D4, ELSET=ALL\n";
  int element = 0;
  for (int x = 0; x <= length; ++x) {
    for (int y = 0; y <= m; ++y) {
      for (int z = 0; z <= m; ++z) {
        const double size_m = 0.1 / m;
        nodes += fmt::format("{}, {:.12g}, {:.12g}, {:.12g}\n", tag(x, y, z), x * size_m,
                             y * size_m, z * size_m);
        if (x == 0) left += fmt::format("{},\n", tag(x, y, z));
        if (x == length) right += fmt::format("{},\n", tag(x, y, z));
        if (x == length || y == m || z == m) continue;
        std::array<int, 3> axes{0, 1, 2};
        do {
          std::array<int, 3> at{x, y, z};
          std::array<int, 4> corner{tag(x, y, z), 0, 0, 0};
          for (std::size_t k = 0; k < 3; ++k) {
            ++at[static_cast<std::size_t>(axes[k])];
            corner[k + 1] = tag(at[0], at[1], at[2]);
          }
          const bool odd = (axes[0] > axes[1]) ^ (axes[0] > axes[2]) ^ (axes[1] > axes[2]);
          if (odd) std::swap(corner[1], corner[2]);
          tets += fmt::format("{}, {}, {}, {}, {}\n", ++element, corner[0], corner[1], corner[2],
                              corner[3]);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
    }
  }
  return nodes + tets + left + right;
}

/// One mesh and how it is coupled.
struct Case {
  int m = 1;
  bool nodal = false;
  double step_s = kPortStep_s;
  int steps = 100;
};

std::string scenario_text(const Case& c) {
  std::string text = fmt::format(
      "name: bar_{0}\nrun: {{duration_s: {1:.9g}, macro_step_s: {2:.9g}}}\n"
      "coupling: {{scheme: explicit_serial, prediction: hold}}\n"
      "fem:\n  mesh: {{file: bar_{0}.inp}}\n"
      "  material: {{young_Pa: 1.0e+6, poisson: 0.3, density_kg_per_m3: 1000}}\n"
      "  mass: lumped\n  fixed: [LEFT]\n"
      "  loads: [{{kind: nodal, set: ALL, force_N: [0, 0, 5]}}]\n",
      c.m, c.steps * c.step_s, c.step_s);
  if (c.nodal) return text + "  coupling: nodal\nmbs: {gravity_m_per_s2: [0, 0, 0]}\n";
  // As heavy against the bar of 3 kg as an explicit coupling needs.
  return text +
         "  solver: {kind: pcg, tolerance: 1.0e-6}\n"
         "ports: [{name: end, body: block, node_set: RIGHT}]\n"
         "mbs:\n  gravity_m_per_s2: [0, 0, 0]\n  bodies: [{name: block, mass_kg: 100, "
         "inertia_kg_m2: [1, 1, 1], position_m: [0.3, 0.05, 0.05]}]\n";
}

struct Cost {
  double step_us = 0.0;  ///< median of the repetitions, writing of the run folder included
  double bytes = 0.0;    ///< per step, both ways
};

Cost cost_of(const std::filesystem::path& folder, const Case& c, Mode mode) {
  const std::filesystem::path file = folder / "scenario.yaml";
  std::ofstream(file) << scenario_text(c);
  const Model model = load_model(file, {});
  std::vector<double> times;
  double bytes = 0.0;
  for (int i = 0; i < kRepetitions; ++i) {
    const std::filesystem::path run = folder / "run";
    std::filesystem::remove_all(run);
    const RunOutcome outcome = run_model(model, RunDirectory::create(run, model.name),
                                         {.mode = mode, .silent = true, .watch = {}});
    require(outcome.exit_code == 0, outcome.summary.value("message", std::string("no message")));
    times.push_back(1e6 * outcome.summary.at("wall_s").get<double>() / c.steps);
    bytes = outcome.summary.at("wire").at("bytes").get<double>() / c.steps;
  }
  std::sort(times.begin(), times.end());
  return {times[kRepetitions / 2], bytes};
}

/// What one mesh costs, coupled either way.
struct Row {
  int nodes = 0;
  std::size_t tets = 0;
  double limit_s = 0.0;  ///< of the nodal coupling
  Cost nodal_lcm, nodal_inproc, port_lcm, port_inproc;
};

Row measure(const std::filesystem::path& folder, int m) {
  std::ofstream(folder / fmt::format("bar_{}.inp", m)) << bar_inp(m);
  Case port{.m = m, .steps = m < 7 ? 200 : 50};
  Case nodal = port;
  nodal.nodal = true;
  nodal.step_s = 1e-6;  // any: to learn the limit
  std::ofstream(folder / "scenario.yaml") << scenario_text(nodal);
  fem::Params params = fem::read_params(load_model(folder / "scenario.yaml", {}).scenario.root);
  const fem::Model model(std::move(params));
  Row row{.nodes = static_cast<int>(model.free.size()),
          .tets = model.mesh.tets.size(),
          .limit_s = fem::explicit_step_limit_s(model)};
  nodal.step_s = 1e-6 * std::floor(0.8e6 * row.limit_s);
  row.nodal_lcm = cost_of(folder, nodal, Mode::Lcm);
  row.nodal_inproc = cost_of(folder, nodal, Mode::Inproc);
  row.port_lcm = cost_of(folder, port, Mode::Lcm);
  row.port_inproc = cost_of(folder, port, Mode::Inproc);
  return row;
}

/// Seconds of computing per simulated second, at the longest step each coupling allows.
std::pair<double, double> per_simulated_second(const Row& row) {
  return {1e-6 * row.nodal_lcm.step_us / row.limit_s, 1e-6 * row.port_lcm.step_us / kPortStep_s};
}

/// Without an exponent.
std::string two_digits(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return fmt::format("{:g}", unit * std::round(value / unit));
}

void print_tables(const std::vector<Row>& rows) {
  fmt::print(
      "| free nodes | tets | nodal, LCM (µs per step) | nodal, one process | rigid port, LCM | "
      "rigid port, one process | nodal (bytes per step) | rigid port |\n"
      "|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows) {
    fmt::print("| {} | {} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.0f} |\n", row.nodes,
               row.tets, row.nodal_lcm.step_us, row.nodal_inproc.step_us, row.port_lcm.step_us,
               row.port_inproc.step_us, row.nodal_lcm.bytes, row.port_lcm.bytes);
  }
  fmt::print(
      "\n| free nodes | longest stable step, nodal (ms) | nodal, LCM (s per simulated second) | "
      "rigid port, LCM, {:g} ms | ratio | ratio in steel |\n|---|---|---|---|---|---|\n",
      1e3 * kPortStep_s);
  for (const Row& row : rows) {
    const auto [nodal, port] = per_simulated_second(row);
    fmt::print("| {} | {:.3f} | {:.2g} | {:.2g} | {} | {} |\n", row.nodes, 1e3 * row.limit_s, nodal,
               port, two_digits(nodal / port), two_digits(kSteel * nodal / port));
  }
}

PlotSeries line(const char* label, const std::vector<Row>& rows, double (*value)(const Row&)) {
  PlotSeries series{.label = label, .x = {}, .y = {}, .markers = true};
  for (const Row& row : rows) {
    series.x.push_back(row.nodes);
    series.y.push_back(value(row));
  }
  return series;
}

Plot plot(const char* title, const char* y_label, std::vector<PlotSeries> series) {
  return {.title = title,
          .x_label = "free nodes",
          .y_label = y_label,
          .x_scale = AxisScale::Logarithmic,
          .y_scale = AxisScale::Logarithmic,
          .series = std::move(series)};
}

void run(const std::string& svg_file) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "tandem_nodal_cost";
  std::filesystem::create_directories(folder);
  std::vector<Row> rows;
  for (int m : {1, 2, 3, 5, 7, 10}) {
    rows.push_back(measure(folder, m));
    std::fprintf(stderr, "%d nodes\n", rows.back().nodes);
  }
  std::filesystem::remove_all(folder);
  print_tables(rows);
  std::ofstream(svg_file) << svg_document(
      {plot("One macro step", "µs per step",
            {line("nodal, LCM", rows, [](const Row& r) { return r.nodal_lcm.step_us; }),
             line("nodal, one process", rows, [](const Row& r) { return r.nodal_inproc.step_us; }),
             line("rigid port, LCM", rows, [](const Row& r) { return r.port_lcm.step_us; }),
             line("rigid port, one proc.", rows,
                  [](const Row& r) { return r.port_inproc.step_us; })}),
       plot("At the longest step", "s per simulated second",
            {line("nodal, LCM", rows, [](const Row& r) { return per_simulated_second(r).first; }),
             line("rigid port, LCM", rows,
                  [](const Row& r) { return per_simulated_second(r).second; })})});
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
