#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "fem_process/body/params.h"
#include "fem_process/transient/transient_step.h"

namespace tandem::fem {

/// A clamped part of tets swung by a harmonic dead load of 2 Hz, macro step 0.01 s, backward Euler,
/// lumped mass, no damping: the case on which steps per second are compared.
struct BenchmarkCase {
  std::string name;  ///< "soft": large motion; "steel": stiff, nearly static
  Material material;
  Eigen::Vector3d force_N;  ///< amplitude of the total force
  int steps = 0;
};
/// "soft": 1 MPa, ν = 0.35, 1100 kg/m³, 20 N along z. "steel": 210 GPa, ν = 0.3, 7850 kg/m³, 2e5 N.
/// Throws a Usage error for other names.
[[nodiscard]] BenchmarkCase benchmark_case(const std::string& name);

/// The case on a mesh, clamped at one node set, loaded at another.
[[nodiscard]] Params benchmark_params(const BenchmarkCase& which, const std::filesystem::path& mesh,
                                      const std::string& clamp, const std::string& load,
                                      const SolverParams& solver);

/// One run of the case.
struct StepBenchmark {
  int nodes = 0;
  int elements = 0;
  double setup_s = 0.0;        ///< reading, analysis, factor at rest
  std::vector<double> step_s;  ///< wall time of each step
  StepTimes times;             ///< sums over the steps
  double iterations_mean = 0.0;
  int not_converged = 0;
  int inverted_elements = 0;          ///< most in any step
  std::size_t memory_bytes = 0;       ///< on the heap for the model, the solver and the state
  std::vector<Eigen::VectorXd> kept;  ///< positions after every 20th step (m)
  double displacement_max_m = 0.0;    ///< of any node, over `kept`
};
/// Throws NotSolved when a step fails.
[[nodiscard]] StepBenchmark run_benchmark(const Params& params, int steps);

/// Largest distance of a node from where `reference` has it, over all kept steps, relative to the
/// reference's largest displacement.
[[nodiscard]] double benchmark_error(const StepBenchmark& run, const StepBenchmark& reference);

}  // namespace tandem::fem
