#pragma once

#include <filesystem>
#include <memory>

#include "protocol/contract/subsystem.h"
#include "protocol/scenario/node.h"

namespace tandem::fem {

/// The flexible side of a scenario, of the model that `fem.model` names. With a `directory` it
/// writes its files there; an empty one writes nothing.
[[nodiscard]] std::unique_ptr<FemSide> make_model(const scenario::Node& root,
                                                  const std::filesystem::path& directory);

}  // namespace tandem::fem
