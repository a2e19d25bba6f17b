#pragma once

#include <vector>

#include "fem_process/material/materials.h"
#include "fem_process/matrix/block_matrix.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

enum class MassKind {
  /// First order: a quarter of the tet's mass on each node. Second order: the mass in proportion to
  /// the diagonal of the consistent matrix [Hinton, Rock, Zienkiewicz 1976], 1/36 at a corner and
  /// 4/27 at a mid node of a straight tet; the row sums would be negative at the corners.
  Lumped,
  Consistent  ///< ∫ ρ N_i N_j dV; first order: ρ V/20 (1 + δ_ij)
};

/// Mass matrix as one number per block (kg): M_ij = m_ij I₃.
[[nodiscard]] std::vector<double> mass_matrix(const TetMesh& mesh, const BlockPattern& pattern,
                                              const Materials& materials, MassKind kind);

/// Row sums of the mass matrix (kg): what gravity acts on, so that a body falls freely without
/// strain. Negative at corners of second-order tets with consistent mass.
[[nodiscard]] std::vector<double> nodal_masses(const BlockPattern& pattern,
                                               const std::vector<double>& mass);

}  // namespace tandem::fem
