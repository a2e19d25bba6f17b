#include "fem_process/sides/step_benchmark.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

constexpr int kKeepEvery = 20;

std::size_t heap_bytes() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

double farthest(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  double most = 0.0;
  for (Eigen::Index i = 0; i < a.size(); i += 3) {
    most = std::max(most, (a.segment<3>(i) - b.segment<3>(i)).norm());
  }
  return most;
}

}  // namespace

BenchmarkCase benchmark_case(const std::string& name) {
  if (name == "soft") {
    return {"soft",
            {.young_Pa = 1e6, .poisson = 0.35, .density_kg_per_m3 = 1100.0},
            Eigen::Vector3d(0, 0, 20.0),
            400};
  }
  require(name == "steel", "fem: the benchmark case '" + name + "' must be soft or steel.");
  return {"steel",
          {.young_Pa = 2.1e11, .poisson = 0.3, .density_kg_per_m3 = 7850.0},
          Eigen::Vector3d(0, 0, 2e5),
          200};
}

Params benchmark_params(const BenchmarkCase& which, const std::filesystem::path& mesh,
                        const std::string& clamp, const std::string& load,
                        const SolverParams& solver) {
  Params params;
  params.mesh.file = mesh;
  params.material = which.material;
  params.mass = MassKind::Lumped;
  params.solver = solver;
  params.micro_step = SimTime(10'000'000);
  params.fixed = {{.name = clamp}};
  params.loads = {{.kind = Load::Kind::Nodal,
                   .set = {.name = load},
                   .value = which.force_N,
                   .law = Law(HarmonicLaw{.amplitude = 1.0, .frequency_Hz = 2.0})}};
  return params;
}

StepBenchmark run_benchmark(const Params& params, int steps) {
  StepBenchmark run;
  const std::size_t heap_before = heap_bytes();
  const double start_s = now_s();
  const Model model(params);
  const TransientStep step(model, {});
  State state;
  WrenchSet wrenches;
  const SolveReport started = step.start({}, state, wrenches);
  if (started.outcome != Outcome::Done)
    throw Error(ErrorKind::NotSolved, "fem: " + started.message);
  run.setup_s = now_s() - start_s;
  run.nodes = model.mesh.nodes();
  run.elements = static_cast<int>(model.mesh.tets.size());
  const Eigen::VectorXd X = model.reference();
  Linearisation kept;
  run.step_s.reserve(static_cast<std::size_t>(steps));
  for (int n = 1; n <= steps; ++n) {
    state.generation = static_cast<std::uint64_t>(n);
    const double begin_s = now_s();
    TransientStep::Result result = step.advance(state, {}, {}, params.micro_step, kept);
    run.step_s.push_back(now_s() - begin_s);
    if (result.report.outcome == Outcome::Failed) {
      throw Error(ErrorKind::NotSolved,
                  "fem: benchmark step " + std::to_string(n) + ": " + result.report.message);
    }
    run.not_converged += result.report.outcome == Outcome::NotConverged ? 1 : 0;
    run.iterations_mean += static_cast<double>(result.report.iterations) / steps;
    run.times.elements_s += result.times.elements_s;
    run.times.factorize_s += result.times.factorize_s;
    run.times.solve_s += result.times.solve_s;
    state = std::move(result.state);
    run.inverted_elements = std::max(run.inverted_elements, state.inverted_elements);
    if (n == 1) run.memory_bytes = heap_bytes() - heap_before;
    if (n % kKeepEvery != 0) continue;
    run.kept.push_back(state.x);
    run.displacement_max_m = std::max(run.displacement_max_m, farthest(state.x, X));
  }
  return run;
}

double benchmark_error(const StepBenchmark& run, const StepBenchmark& reference) {
  double most = 0.0;
  for (std::size_t k = 0; k < reference.kept.size(); ++k) {
    most = std::max(most, farthest(run.kept[k], reference.kept[k]));
  }
  return reference.displacement_max_m > 0.0 ? most / reference.displacement_max_m : most;
}

}  // namespace tandem::fem
