#pragma once

#include "fem_process/body/model.h"
#include "mbs_process/params.h"
#include "orchestrator/scenario/model.h"
#include "orchestrator/warnings/finding.h"
#include "protocol/contract/port.h"

namespace tandem::orchestrator {

/// What a flexible body looks like by itself.
[[nodiscard]] std::vector<Finding> warnings_of(const scenario::Node& root, const fem::Model& body);

/// All warnings on a coupled scenario. `body`: the flexible body on a mesh; null for chains.
/// `origins`: the ports at t = 0.
[[nodiscard]] std::vector<Finding> warnings_of(const Model& model, const mbs::Params& params,
                                               const fem::Model* body, const MotionSet& origins);

}  // namespace tandem::orchestrator
