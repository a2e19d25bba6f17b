#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/scenario/node.h"

namespace tandem::scenario {

/// The `name` of each.
[[nodiscard]] std::vector<std::string> names_of(const std::vector<Node>& nodes);

/// The root with the mapping `own` in the place of `key`, which lists several, and with the ports
/// of these numbers alone.
[[nodiscard]] Node view_of(const Node& root, std::string_view key, const Node& own,
                           const std::vector<std::size_t>& ports);

/// Folders, logs and processes carry the name of a flexible body or a world: throws a Usage error
/// at the place where it is too long or that of a process of every run.
void require_side_name(const Node& side);

}  // namespace tandem::scenario
