#pragma once

#include "fem_process/body/params.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::fem {

/// Section `fem.craig_bampton`: the modes of a reduced body.
[[nodiscard]] scenario::Key craig_bampton_key();
[[nodiscard]] CraigBamptonParams read_craig_bampton(const scenario::Node& node);

}  // namespace tandem::fem
