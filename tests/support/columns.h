#pragma once

#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/tandem_process.h"

namespace tandem::test {

/// The columns of a table of numbers, by name.
using Columns = std::map<std::string, std::vector<double>>;

inline Columns read_columns(const std::filesystem::path& file) {
  std::istringstream text(read_file(file));
  std::string line, cell;
  std::vector<std::string> names;
  std::getline(text, line);
  for (std::istringstream head(line); std::getline(head, cell, ',');) names.push_back(cell);
  Columns columns;
  while (std::getline(text, line)) {
    std::istringstream row(line);
    for (std::size_t i = 0; i < names.size() && std::getline(row, cell, ','); ++i) {
      columns[names[i]].push_back(std::stod(cell));
    }
  }
  return columns;
}

}  // namespace tandem::test
