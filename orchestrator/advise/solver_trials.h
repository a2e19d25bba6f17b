#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "orchestrator/advise/load_trial.h"
#include "protocol/contract/port.h"

namespace tandem::orchestrator {

/// One change of how the steps are solved, beside the candidate without it.
struct SolverTrial {
  std::string name;
  Settings settings;
  std::string status;
  double step_s = 0.0;
  double wall_per_step_s = 0.0;  ///< the least of the repetitions
  double without_wall_per_step_s = 0.0;
  double change = 0.0;  ///< of the port motion, over its travel
  bool taken = false;
};

struct SolverQuestion {
  std::string name;   ///< of the candidate
  Settings settings;  ///< of it
  double step_s = 0.0;
  double length_s = 0.0;  ///< of the run
  double wall_per_step_s = 0.0;
  double accuracy = 1e-3;  ///< wanted error over the travel
  std::filesystem::path folder;
  double deadline_s = 0.0;  ///< of now_s()
};

/// Runs the candidate without and with each change by turns, twice, and takes the changes that save
/// a tenth of the wall time at least and move the ports by a hundredth of the wanted error at most;
/// of two such changes both, if a run shows that they save more together. None where the time does
/// not suffice for 20 steps each.
[[nodiscard]] std::vector<SolverTrial> try_solvers(const LoadTrial& load,
                                                   const std::vector<PortInfo>& ports,
                                                   const SolverQuestion& question);

/// The settings of the changes that were taken.
[[nodiscard]] Settings taken_settings(const std::vector<SolverTrial>& trials);

}  // namespace tandem::orchestrator
