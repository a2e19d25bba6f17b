#include "protocol/scenario/override.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "protocol/contract/error.h"
#include "protocol/scenario/data.h"
#include "protocol/scenario/suggest.h"

namespace tandem::scenario {
namespace {

using Kind = YamlValue::Kind;

/// `bodies[0].mass_kg` is another way to write `bodies.0.mass_kg`.
std::string with_dots(std::string path) {
  std::erase(path, ']');
  std::ranges::replace(path, '[', '.');
  return path;
}

std::vector<std::string> split(const std::string& given) {
  const std::string path = with_dots(given);
  std::vector<std::string> words;
  std::size_t begin = 0;
  for (auto dot = path.find('.'); dot != std::string::npos; dot = path.find('.', begin)) {
    words.push_back(path.substr(begin, dot - begin));
    begin = dot + 1;
  }
  words.push_back(path.substr(begin));
  return words;
}

/// The beginning of a text too long for a line. Every value keeps its place: with the whole text in
/// it, a list of a thousand entries would take gigabytes.
std::string shortened(const std::string& text) {
  constexpr std::size_t kLongest = 120;
  if (text.size() <= kLongest) return text;
  std::size_t end = kLongest;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + "…";
}

/// Walks from the root along the words of the path, in the document and in the table together.
class Walk {
 public:
  Walk(const Override& change, YamlValue value, std::vector<Defect>& defects)
      : words_(split(change.path)), value_(std::move(value)), defects_(defects) {}

  void into_mapping(YamlValue& yaml, const Section& section, std::size_t depth) {
    make_mapping(yaml, section);
    if (yaml.kind != Kind::Mapping) return refuse(depth, "the file has no mapping of keys here.");
    const auto key = std::ranges::find(section.keys, words_[depth], &Key::name);
    if (key == section.keys.end()) {
      return refuse(depth + 1, "is not a key here." + key_remedy(words_[depth], section.keys));
    }
    YamlValue* child = yaml.find(key->name);
    if (depth + 1 == words_.size()) {
      if (child == nullptr) {
        yaml.entries.push_back({key->name, value_.place, value_});
      } else {
        *child = value_;
      }
      return;
    }
    const bool is_list = child != nullptr && child->kind == Kind::List;
    if (key->type == Type::Section && !(key->or_list && is_list)) {
      if (child == nullptr)
        child = &yaml.entries.emplace_back(YamlEntry{key->name, value_.place, {}}).value;
      return into_mapping(*child, *key->section, depth + 1);
    }
    if (!key->section && key->type != Type::Reals && key->type != Type::Names) {
      return refuse(depth + 1, "is a single value; there is nothing below it. Shorten the path.");
    }
    if (!is_list) {
      return refuse(depth + 1, "is not a list in the file. Set the whole list, [a, b, …].");
    }
    into_list(*child, *key, depth + 1);
  }

 private:
  /// A section that is left out, or written as its shorthand, becomes a mapping to put keys into.
  void make_mapping(YamlValue& yaml, const Section& section) const {
    if (yaml.kind == Kind::Null) {
      yaml.kind = Kind::Mapping;
      yaml.place = value_.place;
    } else if (yaml.kind == Kind::Scalar && !section.shorthand.empty()) {
      YamlValue full;
      full.kind = Kind::Mapping;
      full.place = yaml.place;
      full.entries.push_back({section.shorthand, yaml.place, yaml});
      yaml = std::move(full);
    }
  }

  void into_list(YamlValue& list, const Key& key, std::size_t depth) {
    YamlValue* item = find_item(list, words_[depth]);
    if (item == nullptr) {
      std::vector<std::string> names;
      for (const YamlValue& entry : list.items) {
        if (const YamlValue* name = entry.find("name")) names.push_back(name->text);
      }
      std::string near = did_you_mean(words_[depth], names);
      if (near.empty() && !names.empty()) near = fmt::format(" It has {}.", fmt::join(names, ", "));
      return refuse(depth + 1, fmt::format("names no entry of this list. Use a name or an index "
                                           "below {}.{}",
                                           list.items.size(), near));
    }
    if (depth + 1 == words_.size()) {
      *item = value_;
    } else if (key.section) {
      into_mapping(*item, *key.section, depth + 1);
    } else {
      refuse(depth + 1, "is a single value; there is nothing below it. Shorten the path.");
    }
  }

  static YamlValue* find_item(YamlValue& list, const std::string& word) {
    for (YamlValue& entry : list.items) {
      const YamlValue* name = entry.find("name");
      if (name != nullptr && name->text == word) return &entry;
    }
    std::size_t index = 0;
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), index);
    const bool is_index = code == std::errc() && end == word.data() + word.size();
    return is_index && index < list.items.size() ? &list.items[index] : nullptr;
  }

  /// `depth` words of the path are named in the message.
  void refuse(std::size_t depth, std::string text) {
    std::string path;
    for (std::size_t i = 0; i < depth; ++i) path = join_path(path, words_[i]);
    defects_.push_back({value_.place, path, std::move(text)});
  }

  std::vector<std::string> words_;
  YamlValue value_;
  std::vector<Defect>& defects_;
};

}  // namespace

Override parse_override(const std::string& argument) {
  const auto sign = argument.find('=');
  require(sign != std::string::npos && sign > 0,
          fmt::format("--set {}: it must be key=value. Write for example "
                      "--set run.macro_step_s=1e-3.",
                      argument));
  return {argument.substr(0, sign), argument.substr(sign + 1)};
}

void apply_override(YamlValue& root, const Section& table, const Override& change,
                    std::vector<Defect>& defects) {
  const std::string given = change.given_as.empty()
                                ? fmt::format("--set {}={}", change.path, change.value)
                                : change.given_as;
  const Place place{shortened(given), 0, 0};
  const std::size_t defects_before = defects.size();
  auto value = parse_yaml_at(change.value, place, defects);
  if (!value || defects.size() != defects_before) return;
  value->place = place;
  Walk(change, std::move(*value), defects).into_mapping(root, table, 0);
}

}  // namespace tandem::scenario
