#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "mbs_process/rigid_world.h"
#include "protocol/scenario/node.h"

namespace tandem::mbs {

/// The multibody side of a scenario. With a `directory` it writes bodies.csv there, one row per
/// accepted state as `output.bodies_every_steps` says; an empty one writes nothing.
[[nodiscard]] std::unique_ptr<RigidWorld> make_side(const scenario::Node& root,
                                                    const std::filesystem::path& directory);

/// Where a world of so many writes its files within the run's folder: one into the folder itself,
/// several each into a folder of its name, made with the first file. Empty stays empty: no files.
[[nodiscard]] std::filesystem::path folder_of(const std::filesystem::path& run_folder,
                                              const scenario::Node& root, std::size_t worlds);

}  // namespace tandem::mbs
