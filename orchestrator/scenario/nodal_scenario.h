#pragma once

#include <filesystem>
#include <vector>

#include "protocol/scenario/scenario_file.h"

namespace tandem::orchestrator {

/// The overrides with, in front of them, those that put into a scenario with `fem.coupling: nodal`
/// what its mesh stands for: one point mass and one port for every free node, both called
/// node_<tag>; the others may name their parts. Nothing more for other scenarios, and for one that
/// has both already (a resolved one). Throws a Usage error when the scenario lists ports or
/// bodies alone, or when what it says of the flexible side is wrong.
[[nodiscard]] std::vector<scenario::Override> with_nodes(const std::filesystem::path& file,
                                                         std::vector<scenario::Override> overrides);

}  // namespace tandem::orchestrator
