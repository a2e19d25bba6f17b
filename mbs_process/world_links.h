#pragma once

#include <vector>

#include "protocol/scenario/node.h"

namespace tandem::mbs {

/// Joints, springs and forces act within one world; several are coupled through flexible bodies
/// only. `worlds`: the mappings of `mbs`. Throws a Usage error at the place of one that names a
/// body of another world, or of none.
void refuse_links(const std::vector<scenario::Node>& worlds);

}  // namespace tandem::mbs
