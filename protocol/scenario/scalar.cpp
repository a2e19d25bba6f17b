#include "protocol/scenario/scalar.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>

#include "protocol/scenario/key_text.h"
#include "protocol/scenario/node.h"
#include "protocol/scenario/suggest.h"

namespace tandem::scenario {
namespace {

using Kind = YamlValue::Kind;

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string_view without_plus(const std::string& text) {
  return text.starts_with('+') ? std::string_view(text).substr(1) : std::string_view(text);
}

std::string unit_words(const Key& key) {
  return key.unit.empty() ? "is dimensionless" : fmt::format("is in {}", key.unit);
}

/// Why `text` is no number, in the words of the likeliest mistake.
std::string not_a_number(const YamlValue& yaml, const Key& key, const char* what) {
  if (yaml.quoted) {
    return fmt::format("is text (\"{}\"). Write {} without quotes.", yaml.text, what);
  }
  std::string word = lower(yaml.text);
  if (word.starts_with('+') || word.starts_with('-')) word.erase(0, 1);
  if (word == ".nan" || word == "nan" || word == ".inf" || word == "inf" || word == "infinity") {
    return fmt::format("is {}. Write a finite number.", yaml.text);
  }
  double head = 0.0;
  const std::string_view text = without_plus(yaml.text);
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), head);
  const std::string_view rest(end, static_cast<std::size_t>(text.data() + text.size() - end));
  if (code == std::errc() && !rest.empty()) {
    const std::size_t letter = rest.find_first_not_of(' ');
    if (rest.front() == ',') {
      return fmt::format("'{}' is not a number. Write a decimal point, not a comma.", yaml.text);
    }
    const auto first = static_cast<unsigned char>(rest[letter]);
    if (std::isalpha(first) != 0 || first == '%' || first >= 0x80) {
      return fmt::format(
          "'{}' carries a unit. Values are plain numbers in the unit that the key's "
          "name states; this one {}.",
          yaml.text, unit_words(key));
    }
  }
  return fmt::format("'{}' is not {}. Write {} like {}.", yaml.text, what, what,
                     key.type == Type::Integer ? "10" : "0.001 or 1e-3");
}

std::string beyond(const YamlValue& yaml) {
  return fmt::format("{} is beyond what a whole number can be here: {} … {}.", yaml.text,
                     std::numeric_limits<std::int32_t>::min(),
                     std::numeric_limits<std::int32_t>::max());
}

std::string out_of_range(const YamlValue& yaml, const Key& key) {
  return fmt::format("{} is out of range. It must be {}.", yaml.text, range_text(key));
}

}  // namespace

std::string wrong_kind(const YamlValue& yaml, const std::string& must_be) {
  switch (yaml.kind) {
    case Kind::List:
      return fmt::format("is a list. It must be {}.", must_be);
    case Kind::Mapping:
      return fmt::format("is a mapping of keys to values. It must be {}.", must_be);
    case Kind::Scalar:
      return fmt::format("'{}' is a single value. It must be {}.", yaml.text, must_be);
    case Kind::Null:
    case Kind::Refused:
      break;
  }
  return fmt::format("has no value. It must be {}.", must_be);
}

bool is_name(const std::string& text) {
  const auto letter = [](unsigned char c) { return c < 0x80 && std::isalpha(c) != 0; };
  return !text.empty() && letter(static_cast<unsigned char>(text[0])) &&
         std::ranges::all_of(text, [&](unsigned char c) {
           return letter(c) || (c >= '0' && c <= '9') || c == '_';
         });
}

Parsed<double> parse_real(const YamlValue& yaml, const Key& key) {
  if (yaml.kind != Kind::Scalar) return {0.0, wrong_kind(yaml, "a number")};
  double value = 0.0;
  const std::string_view text = without_plus(yaml.text);
  const char* last = text.data() + text.size();
  const auto [end, code] = std::from_chars(text.data(), last, value);
  if (code == std::errc::result_out_of_range && end == last && !yaml.quoted) {
    return {0.0, fmt::format("{} is beyond what a double can hold (2e-308 … 1e308).", yaml.text)};
  }
  if (code != std::errc() || end != last || yaml.quoted || !std::isfinite(value)) {
    return {0.0, not_a_number(yaml, key, "a number")};
  }
  if (!in_range(key, value)) return {0.0, out_of_range(yaml, key)};
  return {value, ""};
}

Parsed<std::int64_t> parse_integer(const YamlValue& yaml, const Key& key) {
  if (yaml.kind != Kind::Scalar) return {0, wrong_kind(yaml, "a whole number")};
  std::int64_t value = 0;
  const std::string_view text = without_plus(yaml.text);
  const char* last = text.data() + text.size();
  const auto [end, code] = std::from_chars(text.data(), last, value);
  if (code == std::errc::result_out_of_range && end == last && !yaml.quoted) {
    return {0, beyond(yaml)};
  }
  if (code != std::errc() || end != last || yaml.quoted) {
    return {0, not_a_number(yaml, key, "a whole number")};
  }
  // Readers may keep it in 32 bits, where a larger one would become another number.
  if (!std::in_range<std::int32_t>(value)) return {0, beyond(yaml)};
  if (!in_range(key, static_cast<double>(value))) return {0, out_of_range(yaml, key)};
  return {value, ""};
}

Parsed<bool> parse_boolean(const YamlValue& yaml) {
  if (yaml.kind != Kind::Scalar) return {false, wrong_kind(yaml, "true or false")};
  if (!yaml.quoted && yaml.text == "true") return {true, ""};
  if (!yaml.quoted && yaml.text == "false") return {false, ""};
  const std::string word = lower(yaml.text);
  std::string remedy = "Write true or false.";
  if (word == "yes" || word == "on" || word == "y" || word == "true") remedy = "Write true.";
  if (word == "no" || word == "off" || word == "n" || word == "false") remedy = "Write false.";
  return {false, fmt::format("'{}' is neither true nor false. {}", yaml.text, remedy)};
}

Parsed<std::string> parse_text(const YamlValue& yaml, const Key& key) {
  if (yaml.kind != Kind::Scalar) return {"", wrong_kind(yaml, type_text(key))};
  if (key.type == Type::Path && yaml.text.empty()) return {"", "is empty. Give a file name."};
  return {yaml.text, ""};
}

Parsed<std::string> parse_name(const YamlValue& yaml) {
  if (yaml.kind != Kind::Scalar) return {"", wrong_kind(yaml, "a name")};
  if (is_name(yaml.text)) return {yaml.text, ""};
  return {"", fmt::format("'{}' is not a name. Begin with a letter, then use letters, digits and "
                          "'_' only.",
                          yaml.text)};
}

Parsed<std::string> parse_any_name(const YamlValue& yaml) {
  if (yaml.kind != Kind::Scalar) return {"", wrong_kind(yaml, "a name")};
  if (yaml.text.empty()) return {"", "is empty. Give a name."};
  return {yaml.text, ""};
}

Parsed<std::string> parse_choice(const YamlValue& yaml, const Key& key) {
  if (yaml.kind != Kind::Scalar) return {"", wrong_kind(yaml, type_text(key))};
  if (std::ranges::find(key.choices, yaml.text) != key.choices.end()) return {yaml.text, ""};
  return {"", fmt::format("'{}' is not known. It must be one of {}.{}", yaml.text,
                          fmt::join(key.choices, ", "), did_you_mean(yaml.text, key.choices))};
}

}  // namespace tandem::scenario
