#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "orchestrator/verdict/verdict.h"
#include "protocol/scenario/scenario_file.h"

namespace CLI {
class App;
}

namespace tandem::orchestrator {

/// `tandem fem`: the flexible side alone. Port nodes and fixed sets stay where they are but for
/// those that fem.analysis.motions moves.
void add_fem(CLI::App& app, int& exit_code);

/// What `tandem fem` writes as fem.json: analysis, nodes, elements, formulation, status, and
///   static     load_steps: [{factor, iterations, …, displacement_m: {SET: mean [x, y, z]}}]
///   modes      frequencies_Hz
///   transient, quasi_static
///              history: {t_s, displacement_m: {SET: [[x, y, z], …]}}, and by moved set force_N and
///              torque_Nm about its frame: what the body exerts there
///   transient  verdict, as in summary.json
struct FemOutcome {
  int exit_code = 0;
  nlohmann::ordered_json results;
};

/// Prints the verdict on a run that reached its end, and adds it to the results.
void add_verdict(const RunBooks& books, FemOutcome& outcome);

/// Runs one analysis and writes its .vtu files to `folder`/fem. `analysis` empty: the scenario's.
[[nodiscard]] FemOutcome run_fem(const scenario::Node& root, const std::string& analysis,
                                 const std::filesystem::path& folder);

}  // namespace tandem::orchestrator
