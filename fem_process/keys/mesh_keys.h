#pragma once

#include "fem_process/mesh/mesh.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::fem {

/// Section `fem.mesh` of a scenario: which file, and where it stands.
[[nodiscard]] scenario::Key mesh_key();
[[nodiscard]] MeshParams read_mesh_params(const scenario::Node& node);

}  // namespace tandem::fem
