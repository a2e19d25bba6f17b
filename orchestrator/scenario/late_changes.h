#pragma once

#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/node.h"

namespace tandem::orchestrator {

/// Throws a Usage error at the place of an entry of fem.changes that no macro step of the run would
/// make. `adaptive`: steps end at the times of changes, so that all before the run's end are made.
void refuse_late_changes(const scenario::Node& root, const scenario::RunParams& run, bool adaptive);

}  // namespace tandem::orchestrator
