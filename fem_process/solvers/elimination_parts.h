#pragma once

#include <vector>

#include "fem_process/solvers/cholmod_solver.h"

namespace tandem::fem {

/// The supernodes of a factor in parts that can be eliminated at the same time: a part is a few
/// whole subtrees of the elimination tree, and what is left, above them all, is the top. The cut
/// depends on the factor alone.
struct EliminationParts {
  std::vector<std::vector<int>> parts;  ///< supernodes, children before parents
  std::vector<int> top;                 ///< children before parents
};
[[nodiscard]] EliminationParts cut(const SupernodalFactor& factor);

}  // namespace tandem::fem
