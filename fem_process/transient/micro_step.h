#pragma once

#include "protocol/contract/sim_time.h"
#include "protocol/scenario/node.h"

namespace tandem::fem {

/// The flexible side's own step.
struct MicroStep {
  SimTime length{};
  bool follows_macro_step = false;  ///< fem.micro_step_s is left out: steps of any macro step
};

/// From `fem.micro_step_s` and `run`. A macro step that is no whole multiple of it is a Usage
/// error.
[[nodiscard]] MicroStep read_micro_step(const scenario::Node& root);

}  // namespace tandem::fem
