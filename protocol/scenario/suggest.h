#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/scenario/key_table.h"

namespace tandem::scenario {

/// The name in `known` that `given` most likely means: equal but for case, begun by it, or
/// nearest by edit distance (at most a third of the letters differ).
[[nodiscard]] std::optional<std::string> nearest(std::string_view given,
                                                 const std::vector<std::string>& known);

/// A key's name without its unit: "macro_step_s" → "macro_step", "v_m_per_s" → "v".
[[nodiscard]] std::string without_unit(std::string_view key);

/// The row that an unknown key most likely means; the same name with another unit comes first.
[[nodiscard]] const Key* nearest_key(std::string_view given, const std::vector<Key>& keys);

/// " Did you mean 'macro_step_s' (s)?", or the list of the keys there are.
[[nodiscard]] std::string key_remedy(std::string_view given, const std::vector<Key>& keys);

}  // namespace tandem::scenario
