// What several flexible bodies cost: time, iterations and messages of a macro step against their
// number, of chains of links (examples/chain_of_links/make.sh), in one process and with a process
// each.
//   bodies_cost SVG_FILE      writes the plot, prints the table of docs/coupling.md

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "orchestrator/page/svg_plot.h"
#include "orchestrator/run/run.h"
#include "protocol/contract/error.h"
#include "protocol/driver/process_memory.h"

namespace tandem::orchestrator {
namespace {

constexpr int kRepetitions = 5;
constexpr int kSteps = 100;

/// What make.sh prints for so many links, its meshes found from anywhere.
std::string chain_of(int links) {
  const std::string script = TANDEM_SOURCE_DIR "/examples/chain_of_links/make.sh";
  const std::string command = fmt::format("sh '{}' {}", script, links);
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  require(pipe != nullptr, "cannot start " + command);
  std::string text;
  std::array<char, 4096> part{};
  for (std::size_t n = 0; (n = fread(part.data(), 1, part.size(), pipe.get())) > 0;) {
    text.append(part.data(), n);
  }
  const std::string relative = "../slider_crank/";
  const std::string folder = TANDEM_SOURCE_DIR "/examples/slider_crank/";
  for (auto at = text.find(relative); at != std::string::npos; at = text.find(relative, at + 1)) {
    text.replace(at, relative.size(), folder);
  }
  return text;
}

struct Cost {
  double step_us = 0.0;  ///< median of the repetitions
  double fem_us = 0.0;   ///< of it, or beside it: computing of all flexible bodies
  double iterations = 0.0;
  double messages = 0.0;
};

Cost cost_of(const Model& model, const std::filesystem::path& folder, Mode mode) {
  std::vector<std::pair<double, double>> times;
  Cost cost;
  for (int i = 0; i < kRepetitions; ++i) {
    std::filesystem::remove_all(folder);
    const RunOutcome outcome = run_model(model, RunDirectory::create(folder, model.name),
                                         {.mode = mode, .silent = true, .watch = {}});
    require(outcome.exit_code == 0, outcome.summary.value("message", std::string("no message")));
    times.emplace_back(
        1e6 * outcome.summary.at("wall_s").get<double>() / kSteps,
        1e6 * outcome.summary.at("ledger_s").at("fem_compute").get<double>() / kSteps);
    cost.iterations = outcome.summary.at("iterations").at("mean").get<double>();
    cost.messages = outcome.summary.at("wire").at("messages").get<double>() / kSteps;
  }
  std::sort(times.begin(), times.end());
  cost.step_us = times[kRepetitions / 2].first;
  cost.fem_us = times[kRepetitions / 2].second;
  return cost;
}

struct Row {
  int links = 0;
  Cost here, lcm;
};

void run(const std::string& svg_file) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / "tandem_bodies_cost";
  std::filesystem::create_directories(folder);
  std::vector<Row> rows;
  for (const int links : {1, 2, 4, 8, 16}) {
    std::ofstream(folder / "chain.yaml") << chain_of(links);
    const Model model =
        load_model(folder / "chain.yaml", {{"run.duration_s", fmt::format("{}", 1e-3 * kSteps)}});
    rows.push_back({.links = links,
                    .here = cost_of(model, folder / "run", Mode::Inproc),
                    .lcm = cost_of(model, folder / "run", Mode::Lcm)});
    std::fprintf(stderr, "%d links\n", links);
  }
  std::filesystem::remove_all(folder);
  fmt::print(
      "| links | iterations | one process (µs per step) | of it the bodies | over LCM | "
      "LCM / one process | messages per step |\n|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows) {
    fmt::print("| {} | {:.2f} | {:.0f} | {:.0f} | {:.0f} | {:.2f} | {:.1f} |\n", row.links,
               row.lcm.iterations, row.here.step_us, row.here.fem_us, row.lcm.step_us,
               row.lcm.step_us / row.here.step_us, row.lcm.messages);
  }
  PlotSeries here{.label = "one process", .x = {}, .y = {}, .markers = true};
  PlotSeries bodies{.label = "of it the bodies",
                    .x = {},
                    .y = {},
                    .markers = true,
                    .dashed = true,
                    .as_before = true};
  PlotSeries lcm{.label = "a process each, LCM", .x = {}, .y = {}, .markers = true};
  for (const Row& row : rows) {
    for (PlotSeries* series : {&here, &bodies, &lcm}) series->x.push_back(row.links);
    here.y.push_back(row.here.step_us);
    bodies.y.push_back(row.here.fem_us);
    lcm.y.push_back(row.lcm.step_us);
  }
  std::ofstream(svg_file) << svg_document({{.title = "One macro step of a chain",
                                            .x_label = "flexible links",
                                            .y_label = "µs per step",
                                            .x_scale = AxisScale::Logarithmic,
                                            .y_scale = AxisScale::Logarithmic,
                                            .series = {here, bodies, lcm}}});
}

}  // namespace
}  // namespace tandem::orchestrator

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: bodies_cost SVG_FILE\n");
    return 2;
  }
  tandem::keep_freed_memory();  // as tandem does
  try {
    tandem::orchestrator::run(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bodies_cost: %s\n", error.what());
    return 4;
  }
  return 0;
}
