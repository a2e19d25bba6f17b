#pragma once

#include "fem_process/ancf/beam_params.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::fem::ancf {

/// Section `fem.ancf` of a scenario: a chain or beam of ANCF elements.
[[nodiscard]] scenario::Key ancf_keys();

/// Reads `fem` of a scenario whose model is `ancf`, with `ports` and `run`, which may be absent
/// where the table allows it.
[[nodiscard]] BeamParams read_beam_params(const scenario::Node& root);

}  // namespace tandem::fem::ancf
