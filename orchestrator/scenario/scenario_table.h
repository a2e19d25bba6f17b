#pragma once

#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::orchestrator {

/// The whole key table: what `tandem check` accepts and the JSON Schema and reference page show.
[[nodiscard]] const scenario::Section& scenario_table();

/// The same table for the flexible side alone: `run`, `coupling`, `ports` and `mbs` may be absent.
[[nodiscard]] const scenario::Section& fem_scenario_table();

/// The mesh, where there is one, is a file that can be read; else its place in the scenario is the
/// error's.
void require_mesh_file(const scenario::Node& root);

/// A list of flexible bodies is for coupled runs: else a Usage error at `fem`.
void require_one_body(const scenario::Node& root);

}  // namespace tandem::orchestrator
