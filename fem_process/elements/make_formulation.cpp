#include "fem_process/elements/make_formulation.h"

#include "fem_process/elements/corotational_tet10.h"
#include "fem_process/elements/corotational_tet4.h"
#include "fem_process/elements/hyperelastic.h"
#include "fem_process/elements/linear_solid.h"

namespace tandem::fem {
namespace {

template <int N>
std::unique_ptr<const Formulation> make(FormulationKind kind, const TetMesh& mesh,
                                        const Materials& materials) {
  switch (kind) {
    case FormulationKind::Linear:
      return std::make_unique<LinearSolid<N>>(mesh, materials);
    case FormulationKind::ConsistentCorotational:
      return std::make_unique<ConsistentCorotational<N>>(mesh, materials);
    case FormulationKind::TotalLagrangian:
      return std::make_unique<TotalLagrangian<N>>(mesh, materials);
    case FormulationKind::Corotational:
    case FormulationKind::CraigBampton:  // K at rest, stresses in turned elements
      break;
  }
  return std::make_unique<SimplifiedCorotational<N>>(mesh, materials);
}

}  // namespace

std::unique_ptr<const Formulation> make_formulation(FormulationKind kind, const TetMesh& mesh,
                                                    const Materials& materials, ThreadTeam* team) {
  // The fast kernels know one pair of Lamé constants.
  const bool fast = kind == FormulationKind::Corotational && materials.uniform_isotropic();
  if (mesh.second_order()) {
    if (fast) return std::make_unique<CorotationalTet10>(mesh, materials.list.front(), team);
    return make<10>(kind, mesh, materials);
  }
  if (fast) return std::make_unique<CorotationalTet4>(mesh, materials.list.front(), team);
  return make<4>(kind, mesh, materials);
}

}  // namespace tandem::fem
