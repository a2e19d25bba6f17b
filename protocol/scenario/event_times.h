#pragma once

#include <vector>

#include "protocol/contract/sim_time.h"
#include "protocol/scenario/node.h"

namespace tandem::scenario {

/// Times in (0, end) at which some mapping of the scenario changes its course, sorted, each once:
/// begin_s and end_s of ramps, times_s of tables (wherever a law stands), and at_s of scheduled
/// changes. A time between two nanoseconds counts as the one before.
[[nodiscard]] std::vector<SimTime> event_times(const Node& root, SimTime end);

}  // namespace tandem::scenario
