#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "protocol/scenario/key_table.h"
#include "protocol/scenario/yaml_tree.h"

namespace tandem::scenario {

/// Either what the scalar holds or "what is wrong. What would be right."
template <class T>
struct Parsed {
  T value{};
  std::string wrong;  ///< empty = good
};

/// Each reads one YAML value as the type of `key` and checks its range.
[[nodiscard]] Parsed<double> parse_real(const YamlValue& yaml, const Key& key);
[[nodiscard]] Parsed<std::int64_t> parse_integer(const YamlValue& yaml, const Key& key);
[[nodiscard]] Parsed<bool> parse_boolean(const YamlValue& yaml);
[[nodiscard]] Parsed<std::string> parse_text(const YamlValue& yaml, const Key& key);
[[nodiscard]] Parsed<std::string> parse_name(const YamlValue& yaml);
/// Not empty; any characters.
[[nodiscard]] Parsed<std::string> parse_any_name(const YamlValue& yaml);
[[nodiscard]] Parsed<std::string> parse_choice(const YamlValue& yaml, const Key& key);

/// "is a list. It must be a number.": a value of the wrong kind.
[[nodiscard]] std::string wrong_kind(const YamlValue& yaml, const std::string& must_be);

[[nodiscard]] bool is_name(const std::string& text);

}  // namespace tandem::scenario
