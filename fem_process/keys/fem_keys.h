#pragma once

#include "fem_process/body/params.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::fem {

/// Section `fem` of a scenario: the flexible body.
[[nodiscard]] scenario::Key fem_keys();

/// Reads the sections `fem`, `ports` and `run` (for the macro step, the default micro step). The
/// last two may be absent where the table allows it.
[[nodiscard]] Params read_params(const scenario::Node& root);

}  // namespace tandem::fem
