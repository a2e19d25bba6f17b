#include "orchestrator/bench_fem_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "fem_process/step_benchmark.h"
#include "orchestrator/text_file.h"
#include "protocol/contract/sim_time.h"

namespace tandem::orchestrator {
namespace {

using Json = nlohmann::ordered_json;

const std::vector<std::string> kSolvers{
    "cholmod",
    "block_jacobi",
    "block_jacobi+projection",
    "rest_factor",
    "rest_factor+projection",
    "warped_rest_factor",
    "warped_rest_factor+projection",
};

struct BenchCommand {
  std::vector<std::string> meshes;
  std::vector<std::string> cases{"soft"};
  std::vector<std::string> solvers = kSolvers;
  double tolerance = 1e-6;
  int steps = 0;
  std::string clamp = "clamp";
  std::string load = "eye";
  std::string json;

  void run() const {
    Json rows = Json::array();
    fmt::print("{:<16} {:<6} {:<29} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7} {:>9} {:>7}\n",
               "mesh", "case", "solver", "median_ms", "p95_ms", "elements", "factorize", "solve",
               "other", "its", "error", "RT");
    for (const std::string& mesh : meshes) {
      for (const std::string& name : cases) measure(mesh, fem::benchmark_case(name), rows);
    }
    if (!json.empty()) write_text_file(json, Json{{"rows", rows}}.dump(2) + "\n");
  }

 private:
  void measure(const std::string& mesh, fem::BenchmarkCase which, Json& rows) const {
    if (steps > 0) which.steps = steps;
    const fem::StepBenchmark reference = fem::run_benchmark(
        fem::benchmark_params(which, mesh, clamp, load, {.kind = fem::SolverKind::Cholmod}),
        which.steps);
    for (const std::string& solver : solvers) {
      const fem::StepBenchmark run = fem::run_benchmark(
          fem::benchmark_params(which, mesh, clamp, load, solver_of(solver)), which.steps);
      Json row = describe(run, fem::benchmark_error(run, reference));
      row["mesh"] = std::filesystem::path(mesh).filename();
      row["case"] = which.name;
      row["threads"] = 1;
      row["solver"] = solver;
      row["tolerance"] = solver == "cholmod" ? 0.0 : tolerance;
      print(row);
      rows.push_back(std::move(row));
    }
  }

  [[nodiscard]] fem::SolverParams solver_of(const std::string& name) const {
    if (name == "cholmod") return {.kind = fem::SolverKind::Cholmod};
    fem::SolverParams solver{.kind = fem::SolverKind::Pcg, .tolerance = tolerance};
    if (!name.ends_with("+projection")) solver.initial_guess = fem::InitialGuess::Previous;
    if (name.starts_with("block_jacobi")) {
      solver.preconditioner = fem::PreconditionerKind::BlockJacobi;
    }
    if (name.starts_with("rest_factor")) {
      solver.preconditioner = fem::PreconditionerKind::RestFactor;
    }
    return solver;
  }

  static Json describe(const fem::StepBenchmark& run, double error) {
    std::vector<double> sorted = run.step_s;
    std::sort(sorted.begin(), sorted.end());
    const double sum = std::accumulate(sorted.begin(), sorted.end(), 0.0);
    const auto count = static_cast<double>(sorted.size());
    const double median = sorted[sorted.size() / 2];
    const double p95 = sorted[sorted.size() * 95 / 100];
    const auto& t = run.times;
    const auto mean_ms = [&](double total_s) { return 1e3 * total_s / count; };
    Json row;
    row["nodes"] = run.nodes;
    row["elements"] = run.elements;
    row["setup_ms"] = 1e3 * run.setup_s;
    row["step_ms"] = {{"median", 1e3 * median}, {"p95", 1e3 * p95}};
    row["phases_ms"] = {{"elements", mean_ms(t.elements_s)},
                        {"factorize", mean_ms(t.factorize_s)},
                        {"solve", mean_ms(t.solve_s)},
                        {"other", mean_ms(sum - t.elements_s - t.factorize_s - t.solve_s)}};
    row["iterations_mean"] = run.iterations_mean;
    row["not_converged"] = run.not_converged;
    row["error_max"] = error;
    row["real_time_ratio"] = 0.01 / median;
    return row;
  }

  static void print(const Json& row) {
    const Json& phases = row.at("phases_ms");
    fmt::print(
        "{:<16} {:<6} {:<29} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>7.1f} "
        "{:>9.1e} "
        "{:>7.1f}\n",
        row.at("mesh").get<std::string>(), row.at("case").get<std::string>(),
        row.at("solver").get<std::string>(), row.at("step_ms").at("median").get<double>(),
        row.at("step_ms").at("p95").get<double>(), phases.at("elements").get<double>(),
        phases.at("factorize").get<double>(), phases.at("solve").get<double>(),
        phases.at("other").get<double>(), row.at("iterations_mean").get<double>(),
        row.at("error_max").get<double>(), row.at("real_time_ratio").get<double>());
  }
};

}  // namespace

void add_bench_fem(CLI::App& bench) {
  auto command = std::make_shared<BenchCommand>();
  CLI::App* sub = bench.add_subcommand("fem", "Steps of the flexible side alone");
  sub->add_option("MESH", command->meshes, "Meshes with a clamped and a loaded node set (metres)")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--case", command->cases, "soft (large motion), steel (stiff)")
      ->delimiter(',')
      ->check(CLI::IsMember({"soft", "steel"}))
      ->capture_default_str();
  sub->add_option("--solver", command->solvers, "Solvers, comma-separated")
      ->delimiter(',')
      ->check(CLI::IsMember(kSolvers))
      ->capture_default_str();
  sub->add_option("--tolerance", command->tolerance, "Of PCG, relative to the right-hand side")
      ->check(CLI::Range(1e-15, 0.1))
      ->capture_default_str();
  sub->add_option("--steps", command->steps, "Steps of 0.01 s [soft 400, steel 200]")
      ->check(CLI::Range(1, 1000000));
  sub->add_option("--clamp", command->clamp, "Node set that is held")->capture_default_str();
  sub->add_option("--load", command->load, "Node set that is loaded")->capture_default_str();
  sub->add_option("--json", command->json, "Also write the rows to this file");
  sub->footer(
      "Median of the run's steps, mean per phase, milliseconds. RT: simulated over wall time.");
  sub->callback([command] { command->run(); });
}

}  // namespace tandem::orchestrator
