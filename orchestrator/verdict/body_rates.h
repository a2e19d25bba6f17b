#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tandem::orchestrator {

/// The fastest turning of a rigid body in a run's bodies.csv.
struct BodyTurn {
  std::string body;
  double rate_rad_per_s = 0.0;
  /// Largest rate times the time from the row before, by which the body turned meanwhile.
  double turn_between_rows_rad = 0.0;
};

/// Of the bodies that are not in `passed_over`; none where the file is missing. Read row by row: it
/// may be far larger than the memory. A row that a killed writer has left unfinished is passed
/// over.
[[nodiscard]] BodyTurn fastest_body(const std::filesystem::path& file,
                                    const std::vector<std::string>& passed_over = {});

}  // namespace tandem::orchestrator
