#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "orchestrator/files/text_file.h"
#include "protocol/wire/journal.h"

namespace tandem::orchestrator {

/// energy.csv: both sides' energy books at the macro steps where they were observed, the first row
/// at t = 0. Per side the seven entries of EnergyBook and balance_error_J since t = 0, then the
/// error of both together and the interface energy defect of the row's own macro step (as in
/// steps.csv). Numbers in the shortest form that reads back to the same bits. No file without rows.
class EnergyTable {
 public:
  /// `parts`: names of the single worlds and flexible bodies, where there are several, in the order
  /// of SideEnergies. Each has columns of its own, behind all others.
  EnergyTable(const std::filesystem::path& directory, std::vector<std::string> parts)
      : path_(directory / "energy.csv"), parts_(std::move(parts)) {}

  void write(const wire::StepRecord& step);
  void flush();

 private:
  std::filesystem::path path_;
  std::vector<std::string> parts_;
  std::optional<TextFile> file_;
  SideEnergies begin_;
};

}  // namespace tandem::orchestrator
