#pragma once

#include <filesystem>
#include <memory>

#include "fem_process/flexible_body.h"
#include "protocol/scenario/node.h"

namespace tandem::fem {

/// The flexible side of a scenario. With a `directory` it writes fem/*.vtu there, every n-th
/// accepted state as `output.vtu_every_steps` says; an empty one writes nothing.
[[nodiscard]] std::unique_ptr<FlexibleBody> make_side(const scenario::Node& root,
                                                      const std::filesystem::path& directory);

}  // namespace tandem::fem
