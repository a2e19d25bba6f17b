#pragma once

#include <string>

#include "protocol/scenario/key_table.h"

namespace tandem::scenario {

/// "a number", "a list of 3 numbers", "one of a, b": what a value must be, for errors and
/// reference.
[[nodiscard]] std::string type_text(const Key& key);

/// "> 0 s", "0 … 1", "" when unbounded.
[[nodiscard]] std::string range_text(const Key& key);

/// "exactly 3", "at least 1", "2 … 4", "" when any.
[[nodiscard]] std::string count_text(const Key& key);

[[nodiscard]] bool in_range(const Key& key, double value);

}  // namespace tandem::scenario
