#pragma once

#include <vector>

#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// ∫ N_i dA over a surface's triangles for every node of the mesh (m²): the nodal forces of a
/// uniform unit traction. Of first order a third of each triangle at its corners; of second order,
/// straight, a third at its mid nodes and nothing at its corners.
[[nodiscard]] std::vector<double> nodal_areas(const TetMesh& mesh, const NodeSet& surface);

}  // namespace tandem::fem
