#include "fem_process/make_formulation.h"

#include "fem_process/corotational_tet4.h"
#include "fem_process/hyperelastic_tet4.h"
#include "fem_process/linear_tet4.h"

namespace tandem::fem {

std::unique_ptr<const Formulation> make_formulation(FormulationKind kind, const TetMesh& mesh,
                                                    const Material& material) {
  switch (kind) {
    case FormulationKind::Linear:
      return std::make_unique<LinearTet4>(mesh, material);
    case FormulationKind::ConsistentCorotational:
      return std::make_unique<ConsistentCorotationalTet4>(mesh, material);
    case FormulationKind::TotalLagrangian:
      return std::make_unique<TotalLagrangianTet4>(mesh, material);
    case FormulationKind::Corotational:
      break;
  }
  return std::make_unique<CorotationalTet4>(mesh, material);
}

}  // namespace tandem::fem
