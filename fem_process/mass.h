#pragma once

#include <vector>

#include "fem_process/block_matrix.h"
#include "fem_process/mesh.h"

namespace tandem::fem {

enum class MassKind {
  Lumped,     ///< a quarter of the tet's mass on each of its nodes
  Consistent  ///< ρ V/20 (1 + δ_ij)
};

/// Mass matrix as one number per block (kg): M_ij = m_ij I₃.
[[nodiscard]] std::vector<double> mass_matrix(const TetMesh& mesh, const BlockPattern& pattern,
                                              double density_kg_per_m3, MassKind kind);

/// Row sums of the mass matrix (kg): what gravity acts on; the same for both kinds.
[[nodiscard]] std::vector<double> nodal_masses(const TetMesh& mesh, double density_kg_per_m3);

}  // namespace tandem::fem
