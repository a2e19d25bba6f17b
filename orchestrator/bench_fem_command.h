#pragma once

namespace CLI {
class App;
}

namespace tandem::orchestrator {

/// `tandem bench fem MESH…`: steps per second of the flexible side alone on the benchmark cases of
/// fem_process/step_benchmark.h, with the error against sparse Cholesky in every step. As JSON:
///   rows: [{mesh, case, nodes, elements, threads, solver, step_ms: {median, p95},
///           phases_ms: {elements, factorize, solve, other}, iterations_mean, error_max,
///           real_time_ratio, setup_ms}]
void add_bench_fem(CLI::App& bench);

}  // namespace tandem::orchestrator
