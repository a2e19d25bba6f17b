#pragma once

#include <map>
#include <string>
#include <vector>

#include "fem_process/body/model.h"
#include "mbs_process/params.h"
#include "orchestrator/scenario/model.h"
#include "orchestrator/warnings/finding.h"

namespace tandem::orchestrator {

/// What flexible bodies hold near a frame of the multibody side that has their ports: of each an
/// equal share for each of its ports, as if at the port's length from it.
struct HeldNear {
  double mass_kg = 0.0;
  double inertia_kg_m2 = 0.0;
};
using HeldMasses = std::map<std::string, HeldNear>;  ///< by the names of the frames

/// Adds what one flexible body holds; `part` is the scenario as it reads it.
void add_held(const scenario::Node& part, const fem::Model& body, HeldMasses& held);

/// The params with junctions as bodies of what is held there: that is what their springs move.
[[nodiscard]] mbs::Params with_held(mbs::Params params, const HeldMasses& held);

/// Junctions whose stand-in inertia matters (integrators of second order, `implicit`) and is more
/// than a hundred times heavier or lighter than what the flexible body holds there.
[[nodiscard]] std::vector<Finding> unlike_stand_in(const Model& model, const mbs::Params& params,
                                                   const fem::Model& body);

}  // namespace tandem::orchestrator
