#pragma once

#include <filesystem>
#include <vector>

#include "protocol/scenario/scenario_file.h"

namespace tandem::orchestrator {

/// With `fem.coupling: nodal`, the bodies and ports that the mesh stands for, as the overrides that
/// put them into the scenario: one point mass and one port for every free node, both called
/// node_<tag>. Nothing for other scenarios, and for one that has them already (a resolved one).
/// What is wrong with the file beside this is left to loading it. Throws a Usage error when the
/// scenario lists bodies of its own without the ports.
[[nodiscard]] std::vector<scenario::Override> nodal_overrides(
    const std::filesystem::path& file, const std::vector<scenario::Override>& overrides);

}  // namespace tandem::orchestrator
