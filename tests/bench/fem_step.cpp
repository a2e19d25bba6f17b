// Google Benchmark of one step of the standard lug: for profilers and for comparing builds. With
// its error, and on other meshes: tandem bench fem.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "fem_process/sides/flexible_body.h"
#include "fem_process/sides/step_benchmark.h"
#include "fem_process/solvers/rest_factor.h"
#include "fem_process/transient/step_matrix.h"
#include "tests/support/fem_box.h"

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

/// A bar of 10080 second-order tets, or of as many nodes (15795, in the same places) of first
/// order.
Params bar(int order, SolverParams solver) {
  const int n = order == 2 ? 1 : 2;
  const std::string text = testing::cells_inp({40 * n, 6 * n, 7 * n}, {0.5, 0.075, 0.0875});
  Params params = benchmark_params(benchmark_case("soft"), testing::temporary_file("bar.inp", text),
                                   "LEFT", "RIGHT", solver);
  params.mesh.order = order;
  return params;
}

void run_steps(benchmark::State& bench, const Params& params) {
  const Model model(params);
  const TransientStep transient(model, {});
  State state;
  WrenchSet wrenches;
  transient.start({}, state, wrenches);
  Linearisation kept;
  std::uint64_t generation = 0;
  std::int64_t iterations = 0;
  StepTimes times;
  for (auto _ : bench) {
    state.generation = ++generation;
    TransientStep::Result result = transient.advance(state, {}, {}, model.params.micro_step, kept);
    iterations += result.report.iterations;
    times.elements_s += result.times.elements_s;
    times.factorize_s += result.times.factorize_s;
    times.solve_s += result.times.solve_s;
    state = std::move(result.state);
  }
  const auto mean = [&](const char* name, double sum) {
    bench.counters[name] = benchmark::Counter(sum, benchmark::Counter::kAvgIterations);
  };
  mean("its", static_cast<double>(iterations));
  mean("elements_ms", 1e3 * times.elements_s);
  mean("factorize_ms", 1e3 * times.factorize_s);
  mean("solve_ms", 1e3 * times.solve_s);
}

void step(benchmark::State& bench) { run_steps(bench, lug(solver_of(bench))); }
// First number: 0 CHOLMOD, 1 block_jacobi, 2 rest_factor, 3 warped_rest_factor. Second: 1
// projection.
BENCHMARK(step)->Args({0, 0})->Args({1, 0})->Args({2, 0})->Args({3, 0})->Args({3, 1})->Unit(
    benchmark::kMillisecond);

/// A step of a bar of elements of the third number's order, on so many threads (fourth number).
void order_step(benchmark::State& bench) {
  Params params = bar(static_cast<int>(bench.range(2)), solver_of(bench));
  params.threads = static_cast<int>(bench.range(3));
  run_steps(bench, params);
}
BENCHMARK(order_step)
    ->ArgsProduct({{3}, {1}, {1, 2}, {1, 2}})
    ->Args({0, 0, 1, 1})
    ->Args({0, 0, 2, 1})
    ->Unit(benchmark::kMillisecond);

/// Their element pass alone.
void order_elements(benchmark::State& bench) {
  const Model model(bar(static_cast<int>(bench.range(0)), {}));
  const Eigen::VectorXd x = 1.01 * model.reference();
  Eigen::VectorXd f;
  BlockValues K;
  for (auto _ : bench) benchmark::DoNotOptimize(model.formulation->evaluate(x, f, K));
}
BENCHMARK(order_elements)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

/// Their derivatives along six directions, of a port.
void order_derivatives(benchmark::State& bench) {
  const Model model(bar(static_cast<int>(bench.range(0)), {}));
  const Eigen::VectorXd x = 1.01 * model.reference();
  const Eigen::MatrixXd dx = Eigen::MatrixXd::Random(x.size(), 6);
  for (auto _ : bench) benchmark::DoNotOptimize(model.formulation->derivatives(x, dx));
}
BENCHMARK(order_derivatives)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

void order_energy(benchmark::State& bench) {
  const Model model(bar(static_cast<int>(bench.range(0)), {}));
  const Eigen::VectorXd x = 1.01 * model.reference();
  for (auto _ : bench) benchmark::DoNotOptimize(model.formulation->energy(x));
}
BENCHMARK(order_energy)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

/// A step of the lug held at its eye, a port at rest, with and without the interface Jacobian
/// (third number), to a tolerance of ten to the minus fourth number.
void port_step(benchmark::State& bench) {
  Params params = lug(solver_of(bench));
  params.solver.tolerance = std::pow(10.0, -static_cast<double>(bench.range(3)));
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
    ->Args({0, 0, 0, 12})
    ->Args({0, 0, 1, 12})
    ->Args({1, 0, 0, 12})
    ->Args({1, 0, 1, 12})
    ->Args({3, 1, 0, 12})
    ->Args({3, 1, 0, 6})
    ->Args({3, 1, 1, 12})
    ->Args({3, 1, 1, 6})
    ->Unit(benchmark::kMillisecond);

/// The six columns of a port's derivative, one by one or side by side, to 1e-12 and, side by side,
/// to its square root.
void columns(benchmark::State& bench) {
  const Model model(lug({}));
  Eigen::VectorXd f_int;
  BlockValues K;
  BlockValues S;
  model.formulation->evaluate(model.reference(), f_int, K);
  const double h_s = to_seconds(model.params.micro_step);
  combine(model.interior, 1.0 / h_s, model.mass, h_s, &K, S, *model.team);
  const RestFactor rest(model.interior.pattern, S);
  SolverParams params{.kind = SolverKind::Pcg, .tolerance = 1e-12};
  const auto solver = make_solver(params, model.interior.pattern, &rest);
  // As far from the rest factor as a moving body is: the matrix of stiffer elements.
  combine(model.interior, 1.0 / h_s, model.mass, 1.5 * h_s, &K, S, *model.team);
  solver->factorize(S);
  const Eigen::MatrixXd b = Eigen::MatrixXd::Random(3 * model.interior.pattern.rows(), 6);
  const Eigen::VectorXd norms = b.colwise().norm();
  Eigen::MatrixXd left;
  std::int64_t iterations = 0;
  for (auto _ : bench) {
    Eigen::MatrixXd x = b;
    if (bench.range(0) == 1) {
      for (Eigen::Index c = 0; c < 6; ++c) {
        Eigen::MatrixXd column = x.col(c);
        iterations += solver->solve(column, norms.segment<1>(c)).iterations;
      }
    } else if (bench.range(0) == 6) {
      iterations += solver->solve(x, norms).iterations;
    } else {
      iterations += solver->solve_roughly(x, norms, left).iterations;
    }
  }
  bench.counters["its"] =
      benchmark::Counter(static_cast<double>(iterations), benchmark::Counter::kAvgIterations);
}
// 1 one by one, 6 side by side, 0 roughly.
BENCHMARK(columns)->Arg(1)->Arg(6)->Arg(0)->Unit(benchmark::kMillisecond);

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
