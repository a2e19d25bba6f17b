#pragma once

#include "protocol/scenario/key_table.h"

namespace tandem::orchestrator {

/// The whole key table: what `tandem check` accepts and the JSON Schema and reference page show.
[[nodiscard]] const scenario::Section& scenario_table();

}  // namespace tandem::orchestrator
