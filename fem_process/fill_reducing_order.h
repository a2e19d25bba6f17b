#pragma once

#include <vector>

#include "fem_process/block_matrix.h"

namespace tandem::fem {

/// Order of elimination of a pattern's nodes by nested dissection (CHOLMOD with METIS): little
/// fill, and an elimination tree with branches of like size. Minimum degree where CHOLMOD was built
/// without METIS. Throws a Usage error when neither works.
[[nodiscard]] std::vector<int> fill_reducing_order(const BlockPattern& pattern);

}  // namespace tandem::fem
