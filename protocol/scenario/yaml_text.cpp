#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <utility>

#include "protocol/scenario/yaml_tree.h"

namespace tandem::scenario {
namespace {

using Kind = YamlValue::Kind;

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '\n') {
      out += "\\n";
    } else if (c == '\t') {
      out += "\\t";
    } else if (code < 0x20 || code == 0x7f) {
      out += fmt::format("\\x{:02x}", code);
    } else {
      out += c;
    }
  }
  out += '"';
  return out;
}

/// Letters, digits and "_.+-": plain in every place of every YAML version.
bool is_plain(const std::string& text) {
  return !text.empty() && std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '.' || c == '+' || c == '-';
  });
}

/// One line: scalars, empty collections, lists of scalars.
std::string in_line(const YamlValue& value) {
  switch (value.kind) {
    case Kind::Null:
    case Kind::Refused:
      return "null";
    case Kind::Scalar:
      return value.quoted || !is_plain(value.text) ? quoted(value.text) : value.text;
    case Kind::Mapping:
      return "{}";
    case Kind::List:
      break;
  }
  std::string out = "[";
  for (const YamlValue& item : value.items) {
    if (out.size() > 1) out += ", ";
    out += in_line(item);
  }
  out += ']';
  return out;
}

bool fits_in_line(const YamlValue& value) {
  if (value.kind == Kind::Mapping) return value.entries.empty();
  if (value.kind != Kind::List) return true;
  return std::ranges::all_of(value.items, [](const YamlValue& item) {
    return item.kind != Kind::List && item.kind != Kind::Mapping;
  });
}

/// The lines of a collection; the first one carries on where `out` ends, at column `indent`.
void append_block(const YamlValue& value, std::size_t indent, std::string& out) {
  const std::string newline = fmt::format("\n{:{}}", "", indent);
  bool first = true;
  for (const YamlEntry& entry : value.entries) {
    if (!std::exchange(first, false)) out += newline;
    out += is_plain(entry.key) ? entry.key : quoted(entry.key);
    out += ':';
    if (fits_in_line(entry.value)) {
      out += ' ';
      out += in_line(entry.value);
    } else {
      out += newline;
      out += "  ";
      append_block(entry.value, indent + 2, out);
    }
  }
  for (const YamlValue& item : value.items) {
    if (!std::exchange(first, false)) out += newline;
    out += "- ";
    if (fits_in_line(item)) {
      out += in_line(item);
    } else {
      append_block(item, indent + 2, out);
    }
  }
}

}  // namespace

std::string to_yaml(const YamlValue& mapping) {
  std::string out;
  if (fits_in_line(mapping)) {
    out = in_line(mapping);
  } else {
    append_block(mapping, 0, out);
  }
  out += '\n';
  return out;
}

}  // namespace tandem::scenario
