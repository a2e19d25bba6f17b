#include "fem_process/mass.h"

namespace tandem::fem {

std::vector<double> mass_matrix(const TetMesh& mesh, const BlockPattern& pattern,
                                double density_kg_per_m3, MassKind kind) {
  std::vector<double> values(pattern.blocks(), 0.0);
  for (const Tet& tet : mesh.tets) {
    const double mass = density_kg_per_m3 * signed_volume(mesh, tet);
    for (int i : tet) {
      for (int j : tet) {
        double share = 0.0;
        if (kind == MassKind::Consistent) {
          share = mass / 20.0 * (i == j ? 2.0 : 1.0);
        } else if (i == j) {
          share = mass / 4.0;
        }
        values[static_cast<std::size_t>(pattern.find(i, j))] += share;
      }
    }
  }
  return values;
}

std::vector<double> nodal_masses(const TetMesh& mesh, double density_kg_per_m3) {
  std::vector<double> masses(mesh.X.size(), 0.0);
  for (const Tet& tet : mesh.tets) {
    const double quarter = density_kg_per_m3 * signed_volume(mesh, tet) / 4.0;
    for (int i : tet) masses[static_cast<std::size_t>(i)] += quarter;
  }
  return masses;
}

}  // namespace tandem::fem
