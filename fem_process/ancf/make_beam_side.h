#pragma once

#include <filesystem>
#include <memory>

#include "fem_process/ancf/beam_body.h"
#include "protocol/scenario/node.h"

namespace tandem::fem::ancf {

/// The chain of a scenario. With a `directory` it writes beam.csv there, and fem/*.vtu every n-th
/// accepted state as `output.vtu_every_steps` says; an empty one writes nothing.
[[nodiscard]] std::unique_ptr<BeamBody> make_beam_side(const scenario::Node& root,
                                                       const std::filesystem::path& directory);

}  // namespace tandem::fem::ancf
