#pragma once

#include <filesystem>
#include <vector>

#include "protocol/scenario/data.h"
#include "protocol/scenario/scenario_file.h"
#include "protocol/scenario/yaml_tree.h"

namespace tandem::scenario {

/// A mapping after validation: what readers ask, and the same complete as YAML.
struct Validated {
  DataPtr data;
  YamlValue resolved;
};

/// Checks the root of a document against the table. Everything wrong is added to `defects`; the
/// result is good only if none was. Paths are made absolute from `folder`.
[[nodiscard]] Validated validate(const YamlValue& root, std::shared_ptr<const Section> table,
                                 const std::filesystem::path& folder, UnknownKeys unknown,
                                 std::vector<Defect>& defects);

}  // namespace tandem::scenario
