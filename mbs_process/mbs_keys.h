#pragma once

#include "mbs_process/params.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::mbs {

/// Section `mbs` of a scenario: the rigid bodies and what connects and drives them.
[[nodiscard]] scenario::Key mbs_keys();

/// What the section says by itself: everything but steps and ports. The table's own check, so that
/// loading a scenario reports its faults together with all others.
[[nodiscard]] Params read_mechanism(const scenario::Node& mbs);

/// Parameters from a scenario whose table holds mbs_keys(), run_keys() and ports_keys(). Throws a
/// Usage error "file:line:column: key: …" for what the table cannot express: unknown bodies, axes
/// that a joint does not have, reversed limits.
[[nodiscard]] Params read_params(const scenario::Node& root);

}  // namespace tandem::mbs
