#include "protocol/scenario/key_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace tandem::scenario {
namespace {

std::string counted(const Key& key, const std::string& one) {
  const std::string count = count_text(key);
  if (count.empty()) return fmt::format("a list of {}s", one);
  return fmt::format("a list of {} {}{}", count, one, count.ends_with(" 1") ? "" : "s");
}

}  // namespace

std::string count_text(const Key& key) {
  const bool capped = key.max_count != Key{}.max_count;
  if (capped && key.min_count == key.max_count) return fmt::format("exactly {}", key.min_count);
  if (capped) return fmt::format("{} … {}", key.min_count, key.max_count);
  return key.min_count > 0 ? fmt::format("at least {}", key.min_count) : "";
}

std::string type_text(const Key& key) {
  switch (key.type) {
    case Type::Real:
      return "a number";
    case Type::Integer:
      return "a whole number";
    case Type::Boolean:
      return "true or false";
    case Type::Text:
      return "text";
    case Type::Name:
      return "a name (a letter, then letters, digits and '_')";
    case Type::Choice:
      return fmt::format("one of {}", fmt::join(key.choices, ", "));
    case Type::Path:
      return "a file name";
    case Type::Reals:
      return counted(key, "number");
    case Type::Names:
      return counted(key, "name");
    case Type::Section:
      return "a mapping of keys to values";
    case Type::Sections:
      return counted(key, "mapping");
  }
  return "";
}

std::string range_text(const Key& key) {
  const std::string unit = key.unit.empty() ? "" : " " + key.unit;
  const bool low = std::isfinite(key.min);
  const bool high = std::isfinite(key.max);
  if (low && high && !key.min_open && !key.max_open) {
    return fmt::format("{} … {}{}", key.min, key.max, unit);
  }
  std::string text;
  if (low) text = fmt::format("{} {}{}", key.min_open ? ">" : "≥", key.min, unit);
  if (low && high) text += " and ";
  if (high) text += fmt::format("{} {}{}", key.max_open ? "<" : "≤", key.max, unit);
  return text;
}

bool in_range(const Key& key, double value) {
  return (key.min_open ? value > key.min : value >= key.min) &&
         (key.max_open ? value < key.max : value <= key.max);
}

}  // namespace tandem::scenario
