#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tandem::orchestrator {

/// A CSV file of numbers with one header line, as a run folder holds them, column by column. An
/// empty or worded cell reads as NaN.
class CsvTable {
 public:
  /// Throws a Usage error "file:line: what. Remedy." for a row of another length than the header. A
  /// last line without its end, as a killed run leaves it, is left out with a remark.
  explicit CsvTable(const std::filesystem::path& file);

  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// Why rows are left out; empty = none is.
  [[nodiscard]] const std::string& remark() const { return remark_; }

  [[nodiscard]] bool has(const std::string& name) const;
  /// Throws a Usage error when there is no such column.
  [[nodiscard]] const std::vector<double>& column(const std::string& name) const;

 private:
  void append(const std::string& line, std::size_t number);

  std::filesystem::path file_;
  std::string remark_;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> columns_;
};

}  // namespace tandem::orchestrator
