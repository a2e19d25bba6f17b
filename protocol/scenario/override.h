#pragma once

#include <vector>

#include "protocol/scenario/scenario_file.h"
#include "protocol/scenario/yaml_tree.h"

namespace tandem::scenario {

/// Puts the value of one --set into the document, before it is validated.
void apply_override(YamlValue& root, const Section& table, const Override& change,
                    std::vector<Defect>& defects);

}  // namespace tandem::scenario
