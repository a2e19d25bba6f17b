#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "mbs_process/state.h"

namespace tandem::mbs {

/// Writes bodies.csv: column t_s, then per body <name>.p_x_m … p_z_m, q_w … q_z, v_x_m_per_s …,
/// w_x_rad_per_s …; numbers in the shortest text that reads back to the same bits.
///
/// Give it to RigidWorld::on_accepted_state(): every n-th accepted state makes a row, beginning
/// with the first. Errors (no such folder, disk full) name the file.
class BodiesCsv {
 public:
  BodiesCsv(std::filesystem::path file, std::vector<std::string> body_names,
            std::int64_t every_steps);

  /// A state of the same time as the last one is not counted again.
  void write(const State& state);
  void finish();

 private:
  void require_good();

  std::filesystem::path file_;
  std::ofstream stream_;
  std::int64_t every_steps_;
  std::int64_t accepted_ = 0;
  std::optional<SimTime> last_time_;
};

}  // namespace tandem::mbs
