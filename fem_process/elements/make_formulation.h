#pragma once

#include <memory>

#include "fem_process/elements/formulation.h"
#include "fem_process/elements/formulation_kind.h"
#include "fem_process/material/materials.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// For the mesh's order.
[[nodiscard]] std::unique_ptr<const Formulation> make_formulation(FormulationKind kind,
                                                                  const TetMesh& mesh,
                                                                  const Materials& materials,
                                                                  ThreadTeam* team = nullptr);

}  // namespace tandem::fem
