#pragma once

#include <filesystem>
#include <memory>

#include "mbs_process/rigid_world.h"
#include "protocol/scenario/node.h"

namespace tandem::mbs {

/// The multibody side of a scenario. With a `directory` it writes bodies.csv there, one row per
/// accepted state as `output.bodies_every_steps` says; an empty one writes nothing.
[[nodiscard]] std::unique_ptr<RigidWorld> make_side(const scenario::Node& root,
                                                    const std::filesystem::path& directory);

}  // namespace tandem::mbs
