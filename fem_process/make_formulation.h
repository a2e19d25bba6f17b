#pragma once

#include <memory>

#include "fem_process/formulation.h"
#include "fem_process/materials.h"
#include "fem_process/mesh.h"
#include "fem_process/params.h"

namespace tandem::fem {

/// For the mesh's order.
[[nodiscard]] std::unique_ptr<const Formulation> make_formulation(FormulationKind kind,
                                                                  const TetMesh& mesh,
                                                                  const Materials& materials,
                                                                  ThreadTeam* team = nullptr);

}  // namespace tandem::fem
