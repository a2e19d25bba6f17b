#pragma once

#include <optional>
#include <string>
#include <vector>

#include "protocol/scenario/node.h"

namespace tandem::orchestrator {

/// What `tandem check` warns of: a scenario that runs, but hardly as it is meant.
struct Finding {
  std::string name;  ///< "implausible_size"
  std::string text;  ///< "file:line:column: key: what, with numbers. Remedy."
};

/// The finding at a key of a mapping, or at the mapping where the key is left out.
[[nodiscard]] inline Finding finding_at(const scenario::Node& node, const std::string& key,
                                        const std::string& name, const std::string& text) {
  return {.name = name, .text = node.place(key).text() + ": " + node.path_name(key) + ": " + text};
}

}  // namespace tandem::orchestrator
