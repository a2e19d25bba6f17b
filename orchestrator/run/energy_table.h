#pragma once

#include <filesystem>
#include <optional>

#include "orchestrator/files/text_file.h"
#include "protocol/wire/journal.h"

namespace tandem::orchestrator {

/// energy.csv: both sides' energy books at the macro steps where they were observed, the first row
/// at t = 0. Per side the seven entries of EnergyBook and balance_error_J since t = 0, then the
/// error of both together and the interface energy defect of the row's own macro step (as in
/// steps.csv). Numbers in the shortest form that reads back to the same bits. No file without rows.
class EnergyTable {
 public:
  explicit EnergyTable(const std::filesystem::path& directory) : path_(directory / "energy.csv") {}

  void write(const wire::StepRecord& step);
  void flush();

 private:
  std::filesystem::path path_;
  std::optional<TextFile> file_;
  SideEnergies begin_;
};

}  // namespace tandem::orchestrator
