#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "protocol/contract/subsystem.h"
#include "protocol/scenario/node.h"

namespace tandem::fem {

/// The flexible side of a scenario, of the model that `fem.model` names. With a `directory` it
/// writes its files there; an empty one writes nothing.
[[nodiscard]] std::unique_ptr<FemSide> make_model(const scenario::Node& root,
                                                  const std::filesystem::path& directory);

/// Where a body of so many writes its files within the run's folder: one into the folder itself,
/// several each into a folder of its name, made with the first file. Empty stays empty: no files.
[[nodiscard]] std::filesystem::path folder_of(const std::filesystem::path& run_folder,
                                              const scenario::Node& root, std::size_t bodies);

}  // namespace tandem::fem
