#pragma once

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "fem_process/ancf/beam_system.h"
#include "fem_process/ancf/chain_path.h"
#include "protocol/contract/error.h"

namespace tandem::fem::ancf::testing {

/// Rows of a CSV file as text fields by column name. Lines that begin with '#' are passed over.
using Row = std::map<std::string, std::string>;
inline std::vector<Row> read_table(const std::string& file) {
  std::ifstream stream(file);
  require(stream.good(), "cannot read " + file);
  std::vector<std::string> columns;
  std::vector<Row> rows;
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::vector<std::string> fields;
    std::stringstream text(line);
    for (std::string field; std::getline(text, field, ',');) fields.push_back(field);
    if (columns.empty()) {
      columns = fields;
      continue;
    }
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < fields.size() && i < columns.size(); ++i) {
      row[columns[i]] = fields[i];
    }
  }
  return rows;
}
/// Those of a file of tests/data/ancf.
inline std::vector<Row> read_rows(const std::string& name) {
  return read_table(std::string(TANDEM_SOURCE_DIR) + "/tests/data/ancf/" + name);
}

inline double number(const Row& row, const std::string& column) {
  return std::stod(row.at(column));
}

/// A straight beam along x, clamped at x = 0.
inline BeamModel straight_beam(double length_m, int elements, const BeamSection& section,
                               const BeamMaterial& material,
                               Integration integration = Integration::Full,
                               Support left = Support::Clamped) {
  BeamModel model{.mesh = join(lay(LinePath{.length_m = length_m}, {.elements = elements})),
                  .section = section,
                  .material = material,
                  .integration = integration};
  support(model.mesh, false, left);
  return model;
}

/// The rubber of the track.
inline BeamMaterial track_rubber() {
  return {.mu_Pa = 1e8,
          .k_Pa = 1e9,
          .density_kg_per_m3 = 2000.0,
          .dilatation_s = 1e-4,
          .deviation_s = 1e-4};
}
inline constexpr BeamSection kTrackSection{0.4, 0.02};

}  // namespace tandem::fem::ancf::testing
