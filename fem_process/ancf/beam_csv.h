#pragma once

#include <filesystem>
#include <fstream>
#include <vector>

#include "fem_process/ancf/beam_body.h"

namespace tandem::fem::ancf {

/// Writes beam.csv: per accepted state t_s, energies, what the grounds feel (N), largest depths
/// (m), pins on teeth, Newton iterations so far, then per watched point <name>.p_x_m …,
/// <name>.v_x_m_per_s …; axes of W, numbers in the shortest text that reads back exactly.
class BeamCsv {
 public:
  BeamCsv(std::filesystem::path file, const std::vector<WatchPoint>& watch);

  /// Appends the row of the body's present state. A state of the same time as the last one is not
  /// written again. Throws a System error that names the file when it cannot be written.
  void write(const BeamBody& body);
  void finish();

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
  SimTime last_{-1};
};

}  // namespace tandem::fem::ancf
