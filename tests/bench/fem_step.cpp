// Google Benchmark of one step of the standard lug: for profilers and for comparing builds. With
// its error, and on other meshes: tandem bench fem.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <utility>

#include "fem_process/flexible_body.h"
#include "fem_process/step_benchmark.h"

namespace tandem::fem {
namespace {

Params lug(SolverParams solver) {
  return benchmark_params(benchmark_case("soft"), TANDEM_SOURCE_DIR "/tests/data/fem/lug_1k.msh",
                          "clamp", "eye", solver);
}

SolverParams solver_of(const benchmark::State& bench) {
  if (bench.range(0) == 0) return {.kind = SolverKind::Cholmod};
  return {.kind = SolverKind::Pcg,
          .tolerance = 1e-6,
          .preconditioner = static_cast<PreconditionerKind>(bench.range(0) - 1),
          .initial_guess = static_cast<InitialGuess>(bench.range(1))};
}

void step(benchmark::State& bench) {
  const Model model(lug(solver_of(bench)));
  const TransientStep transient(model, {});
  State state;
  WrenchSet wrenches;
  transient.start({}, state, wrenches);
  Linearisation kept;
  std::uint64_t generation = 0;
  std::int64_t iterations = 0;
  for (auto _ : bench) {
    state.generation = ++generation;
    TransientStep::Result result = transient.advance(state, {}, {}, model.params.micro_step, kept);
    iterations += result.report.iterations;
    state = std::move(result.state);
  }
  bench.counters["its"] =
      benchmark::Counter(static_cast<double>(iterations), benchmark::Counter::kAvgIterations);
}
// First number: 0 CHOLMOD, 1 block_jacobi, 2 rest_factor, 3 warped_rest_factor. Second: 1
// projection.
BENCHMARK(step)->Args({0, 0})->Args({1, 0})->Args({2, 0})->Args({3, 0})->Args({3, 1})->Unit(
    benchmark::kMillisecond);

/// A step of the lug held at its eye, a port at rest, with and without the interface Jacobian.
void port_step(benchmark::State& bench) {
  Params params = lug(solver_of(bench));
  params.solver.tolerance = 1e-12;
  params.loads.clear();
  params.gravity_m_per_s2 = {0, 0, -9.81};
  params.ports = {{.name = "eye", .set = {.name = "eye"}}};
  FlexibleBody body(params);
  const MotionSet still(1);
  body.initialize(still);
  const StepRequest<MotionSet> request{
      .step = params.micro_step, .input = {still, still}, .linearize = bench.range(2) != 0};
  for (auto _ : bench) benchmark::DoNotOptimize(body.advance(request));
}
BENCHMARK(port_step)
    ->Args({0, 0, 0})
    ->Args({0, 0, 1})
    ->Args({1, 0, 0})
    ->Args({1, 0, 1})
    ->Args({3, 1, 0})
    ->Args({3, 1, 1})
    ->Unit(benchmark::kMillisecond);

void elements(benchmark::State& bench) {
  const Model model(lug({}));
  const Eigen::VectorXd x = model.reference();
  Eigen::VectorXd f;
  BlockValues K;
  for (auto _ : bench) benchmark::DoNotOptimize(model.formulation->evaluate(x, f, K));
}
BENCHMARK(elements)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace tandem::fem

BENCHMARK_MAIN();
