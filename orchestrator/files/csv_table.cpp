#include "orchestrator/files/csv_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <sstream>

#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(std::move(cell));
  if (line.ends_with(',')) cells.emplace_back();
  return cells;
}

double number_of(const std::string& cell) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  const bool whole = error == std::errc() && end == cell.data() + cell.size();
  return whole ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

CsvTable::CsvTable(const std::filesystem::path& file) : file_(file) {
  std::ifstream stream(file);
  std::string line;
  require(static_cast<bool>(std::getline(stream, line)),
          fmt::format("{}: cannot be read, or is empty. Is it a run folder?", file.string()));
  names_ = cells_of(line);
  columns_.resize(names_.size());
  for (std::size_t number = 2; std::getline(stream, line); ++number) {
    if (!stream.eof()) {
      append(line, number);
    } else if (!line.empty()) {
      remark_ = fmt::format(
          "{}:{}: the last row has no end: its writer was killed, or the disk was full. It is left "
          "out.",
          file.string(), number);
    }
  }
}

void CsvTable::append(const std::string& line, std::size_t number) {
  const std::vector<std::string> cells = cells_of(line);
  require(cells.size() == names_.size(),
          fmt::format("{}:{}: {} values under {} names. Write the file again.", file_.string(),
                      number, cells.size(), names_.size()));
  for (std::size_t i = 0; i < cells.size(); ++i) columns_[i].push_back(number_of(cells[i]));
}

bool CsvTable::has(const std::string& name) const {
  return std::find(names_.begin(), names_.end(), name) != names_.end();
}

const std::vector<double>& CsvTable::column(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  require(found != names_.end(), fmt::format("{}: there is no column '{}'", file_.string(), name));
  return columns_[static_cast<std::size_t>(found - names_.begin())];
}

}  // namespace tandem::orchestrator
