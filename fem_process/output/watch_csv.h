#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "fem_process/body/flexible_side.h"

namespace tandem::fem {

/// Writes watch.csv: the mean motion of every watched node set at accepted states. Columns t_s,
/// then per set <name>.p_x_m …, <name>.u_x_m … (displacement from the mesh as placed),
/// <name>.v_x_m_per_s …; unweighted means over the nodes, axes of W, numbers in the shortest text
/// that reads back exactly.
class WatchCsv {
 public:
  WatchCsv(std::filesystem::path file, std::vector<std::string> node_sets);

  /// Appends the row of a nodal state. A state of the same time as the last one is not
  /// written again. Throws a System error that names the file when it cannot be written.
  void write(const Model& model, const State& state);
  void finish();

 private:
  std::filesystem::path file_;
  std::vector<std::string> node_sets_;
  std::ofstream stream_;
  SimTime last_{-1};
};

}  // namespace tandem::fem
