#pragma once

#include "fem_process/body/model.h"

namespace tandem::fem {

/// Throws a Usage error when the prescribed nodes leave the body, or a part of it that shares no
/// node with the rest, free to move as a rigid one: statics needs three prescribed nodes of each
/// part that are not in line. A cheap look at the mesh, no factorisation.
void require_held(const Model& model);

}  // namespace tandem::fem
