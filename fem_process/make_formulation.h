#pragma once

#include <memory>

#include "fem_process/formulation.h"
#include "fem_process/material.h"
#include "fem_process/mesh.h"
#include "fem_process/params.h"

namespace tandem::fem {

[[nodiscard]] std::unique_ptr<const Formulation> make_formulation(FormulationKind kind,
                                                                  const TetMesh& mesh,
                                                                  const Material& material);

}  // namespace tandem::fem
