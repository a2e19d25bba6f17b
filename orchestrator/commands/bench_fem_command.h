#pragma once

namespace CLI {
class App;
}

namespace tandem::orchestrator {

/// `tandem bench fem MESH…`: steps per second of the flexible side alone on the benchmark cases of
/// fem_process/sides/step_benchmark.h, with the error against sparse Cholesky in every step. As
/// JSON:
///   rows: [{mesh, case, nodes, elements, threads, solver, tolerance, max_iterations,
///           step_ms: {median, p95, min}, phases_ms: {elements, factorize, solve, other},
///           iterations_mean, not_converged, inverted_elements, error_max, real_time_ratio,
///           to_block_jacobi, memory_MB, setup_ms}]
void add_bench_fem(CLI::App& bench);

}  // namespace tandem::orchestrator
