#pragma once

#include <vector>

#include "fem_process/body/model.h"
#include "orchestrator/warnings/finding.h"

namespace tandem::orchestrator {

/// Sets that are held, loaded or hang on a port and have corners of second-order elements, but none
/// of the nodes in the middle of the edges between them: programs whose lists of nodes come from
/// first-order faces write such sets, and a part held by them is softer.
[[nodiscard]] std::vector<Finding> corner_nodes_only(const fem::Model& model);

}  // namespace tandem::orchestrator
