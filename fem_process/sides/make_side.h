#pragma once

#include <filesystem>
#include <memory>

#include "fem_process/body/flexible_side.h"
#include "protocol/scenario/node.h"

namespace tandem::fem {

/// The flexible side of a scenario. With a `directory` it writes fem/*.vtu there, every n-th
/// accepted state as `output.vtu_every_steps` says; an empty one writes nothing.
[[nodiscard]] std::unique_ptr<FlexibleSide> make_side(const scenario::Node& root,
                                                      const std::filesystem::path& directory);

/// The body that the formulation calls for, without files.
[[nodiscard]] std::unique_ptr<FlexibleSide> make_body(Params params);

}  // namespace tandem::fem
