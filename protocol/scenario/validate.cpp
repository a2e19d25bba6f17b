#include "protocol/scenario/validate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "protocol/scenario/key_text.h"
#include "protocol/scenario/scalar.h"
#include "protocol/scenario/suggest.h"

namespace tandem::scenario {
namespace {

using Kind = YamlValue::Kind;
using SectionPtr = std::shared_ptr<const Section>;

/// A value of one key, typed, beside its YAML.
struct Checked {
  Value value;
  YamlValue resolved;
};

class Validator {
 public:
  Validator(std::filesystem::path folder, UnknownKeys unknown, std::vector<Defect>& defects)
      : folder_(std::move(folder)), unknown_(unknown), defects_(defects) {}

  Validated mapping(const YamlValue& yaml, const SectionPtr& section, const std::string& path) {
    if (yaml.kind == Kind::Scalar && !section->shorthand.empty()) {
      return mapping(expand_shorthand(yaml, *section), section, path);
    }
    Validated result;
    if (yaml.kind != Kind::Mapping) {
      refuse(yaml, path, wrong_kind(yaml, "a mapping of keys to values"));
      return result;
    }
    const std::size_t faults_before = faults_;
    auto data = std::make_shared<Data>();
    data->place = yaml.place;
    data->path_name = path;
    data->section = section;
    result.resolved.kind = Kind::Mapping;
    result.resolved.place = yaml.place;
    const std::set<std::string> meant = check_known(yaml, *section, path, result.resolved);
    for (const Key& key : section->keys) {
      if (auto checked = row(yaml, *section, key, path, meant)) {
        put(result.resolved, key.name, std::move(checked->resolved));
        data->values.emplace(key.name, std::move(checked->value));
      }
    }
    result.data = std::move(data);
    if (section->check && faults_ == faults_before) run_check(*section, result.data);
    return result;
  }

 private:
  static YamlValue expand_shorthand(const YamlValue& yaml, const Section& section) {
    YamlValue full;
    full.kind = Kind::Mapping;
    full.place = yaml.place;
    full.entries.push_back({section.shorthand, yaml.place, yaml});
    return full;
  }

  void report(const Place& place, std::string path, std::string text) {
    defects_.push_back({place, std::move(path), std::move(text)});
    ++faults_;
  }

  /// A value that the parser refused is a fault here too, but it has been reported.
  void refuse(const YamlValue& yaml, const std::string& path, std::string text) {
    if (yaml.kind == Kind::Refused) {
      ++faults_;
    } else {
      report(yaml.place, path, std::move(text));
    }
  }

  static void put(YamlValue& mapping, const std::string& key, YamlValue value) {
    if (YamlValue* slot = mapping.find(key)) {
      *slot = std::move(value);
    } else {
      mapping.entries.push_back({key, {}, std::move(value)});
    }
  }

  /// Reports unknown keys; returns the rows they probably mean, which then are not also "missing".
  /// A reader that passes over unknown keys keeps the order of the file in `resolved`.
  std::set<std::string> check_known(const YamlValue& yaml, const Section& section,
                                    const std::string& path, YamlValue& resolved) {
    std::set<std::string> meant;
    for (const YamlEntry& entry : yaml.entries) {
      if (unknown_ == UnknownKeys::Ignore) resolved.entries.push_back(entry);
      const auto row = std::ranges::find(section.keys, entry.key, &Key::name);
      if (row != section.keys.end() || unknown_ == UnknownKeys::Ignore) continue;
      const Key* near = nearest_key(entry.key, section.keys);
      if (near != nullptr && yaml.find(near->name) == nullptr) meant.insert(near->name);
      report(entry.place, join_path(path, entry.key),
             fmt::format("is not a key here.{}", key_remedy(entry.key, section.keys)));
    }
    return meant;
  }

  std::optional<Checked> row(const YamlValue& yaml, const Section& section, const Key& key,
                             const std::string& path, const std::set<std::string>& meant) {
    const std::string key_path = join_path(path, key.name);
    const YamlValue* given = yaml.find(key.name);
    if (!key.when_key.empty()) {
      const std::optional<std::string> kind = chosen(yaml, section, key.when_key);
      if (!kind) return std::nullopt;  // the Choice itself is wrong and reported
      if (std::ranges::find(key.when_values, *kind) == key.when_values.end()) {
        if (given != nullptr) {
          refuse(
              *given, key_path,
              fmt::format("is not used when {} is {}, only when it is {}. Remove it or change {}.",
                          key.when_key, *kind, fmt::join(key.when_values, " or "), key.when_key));
        }
        return std::nullopt;
      }
    }
    if (given != nullptr) return value(*given, key, key_path);
    if (key.default_text) return default_value(yaml.place, key, key_path);
    if (key.required && !meant.contains(key.name)) {
      const std::string unit = key.unit.empty() ? "" : fmt::format(" in {}", key.unit);
      report(yaml.place, key_path, fmt::format("is missing. Give {}{}.", type_text(key), unit));
    }
    return std::nullopt;
  }

  /// The value of the Choice that decides whether a row is used, from the file or its default.
  static std::optional<std::string> chosen(const YamlValue& yaml, const Section& section,
                                           const std::string& name) {
    const auto row = std::ranges::find(section.keys, name, &Key::name);
    if (row == section.keys.end()) throw std::logic_error("only_when names no key: " + name);
    if (const YamlValue* given = yaml.find(name)) {
      const auto parsed = parse_choice(*given, *row);
      return parsed.wrong.empty() ? std::optional(parsed.value) : std::nullopt;
    }
    return row->default_text;
  }

  std::optional<Checked> default_value(const Place& place, const Key& key,
                                       const std::string& path) {
    const std::size_t defects_before = defects_.size();
    std::optional<Checked> checked;
    if (const auto yaml = parse_yaml_at(*key.default_text, place, defects_)) {
      checked = value(*yaml, key, path);
    }
    if (defects_.size() != defects_before) {
      throw std::logic_error("bad default in the table: " + defect_line(defects_.back()));
    }
    return checked;
  }

  std::optional<Checked> value(const YamlValue& yaml, const Key& key, const std::string& path) {
    switch (key.type) {
      case Type::Real:
        return scalar(yaml, path, parse_real(yaml, key), false);
      case Type::Integer:
        return scalar(yaml, path, parse_integer(yaml, key), false);
      case Type::Boolean:
        return scalar(yaml, path, parse_boolean(yaml), false);
      case Type::Text:
        return scalar(yaml, path, parse_text(yaml, key), true);
      case Type::Name:
        return scalar(yaml, path, parse_name(yaml), true);
      case Type::Choice:
        return scalar(yaml, path, parse_choice(yaml, key), true);
      case Type::Path:
        return file(yaml, key, path);
      case Type::Reals:
        return scalars<double>(yaml, key, path,
                               [&](const YamlValue& item) { return parse_real(item, key); });
      case Type::Names:
        return scalars<std::string>(yaml, key, path, [&](const YamlValue& item) {
          return key.any_text ? parse_any_name(item) : parse_name(item);
        });
      case Type::Section: {
        if (key.or_list && yaml.kind == Kind::List) return mappings(yaml, key, path);
        Validated inner = mapping(yaml, key.section, path);
        return Checked{{yaml.place, std::move(inner.data)}, std::move(inner.resolved)};
      }
      case Type::Sections:
        return mappings(yaml, key, path);
    }
    return std::nullopt;
  }

  /// Numbers and booleans keep the user's text; texts are quoted, so that no other reader takes
  /// the name `no` for a boolean.
  template <class T>
  std::optional<Checked> scalar(const YamlValue& yaml, const std::string& path, Parsed<T> parsed,
                                bool quoted) {
    if (!parsed.wrong.empty()) {
      refuse(yaml, path, std::move(parsed.wrong));
      return std::nullopt;
    }
    return Checked{{yaml.place, std::move(parsed.value)},
                   yaml_scalar(yaml.text, quoted, yaml.place)};
  }

  std::optional<Checked> file(const YamlValue& yaml, const Key& key, const std::string& path) {
    auto parsed = parse_text(yaml, key);
    if (!parsed.wrong.empty()) return scalar(yaml, path, std::move(parsed), true);
    const std::string absolute = (folder_ / parsed.value).lexically_normal().string();
    return Checked{{yaml.place, absolute}, yaml_scalar(absolute, true, yaml.place)};
  }

  bool check_list(const YamlValue& yaml, const Key& key, const std::string& path) {
    if (yaml.kind != Kind::List) {
      refuse(yaml, path, wrong_kind(yaml, type_text(key)));
      return false;
    }
    if (yaml.items.size() >= key.min_count && yaml.items.size() <= key.max_count) return true;
    refuse(yaml, path,
           fmt::format("has {} {}. It must be {}.", yaml.items.size(),
                       yaml.items.size() == 1 ? "entry" : "entries", type_text(key)));
    return false;
  }

  template <class T, class Parse>
  std::optional<Checked> scalars(const YamlValue& yaml, const Key& key, const std::string& path,
                                 const Parse& parse) {
    if (!check_list(yaml, key, path)) return std::nullopt;
    const std::size_t faults_before = faults_;
    std::vector<T> values;
    YamlValue resolved = yaml;
    for (std::size_t i = 0; i < yaml.items.size(); ++i) {
      Parsed<T> parsed = parse(yaml.items[i]);
      if (!parsed.wrong.empty()) {
        refuse(yaml.items[i], join_path(path, std::to_string(i)), std::move(parsed.wrong));
      }
      resolved.items[i].quoted = key.type == Type::Names;
      values.push_back(std::move(parsed.value));
    }
    if constexpr (std::is_same_v<T, double>) {
      if (key.unit_length && faults_ == faults_before) check_norm(yaml, path, values);
    }
    return Checked{{yaml.place, std::move(values)}, std::move(resolved)};
  }

  void check_norm(const YamlValue& yaml, const std::string& path, const std::vector<double>& x) {
    double squares = 0.0;
    for (const double component : x) squares += component * component;
    const double norm = std::sqrt(squares);
    if (std::abs(norm - 1.0) <= 1e-3) return;
    if (norm == 0.0) return refuse(yaml, path, "is all zeros. Its norm must be 1.");
    refuse(yaml, path,
           fmt::format("has the norm {:.6g}. It must be 1: divide each number by {:.6g}.", norm,
                       norm));
  }

  std::optional<Checked> mappings(const YamlValue& yaml, const Key& key, const std::string& path) {
    if (!check_list(yaml, key, path)) return std::nullopt;
    if (key.or_list && yaml.items.empty()) {
      refuse(yaml, path, "is an empty list. Give one mapping, or a list of named ones.");
      return std::nullopt;
    }
    const auto name_row = std::ranges::find(key.section->keys, "name", &Key::name);
    const bool named = name_row != key.section->keys.end() && name_row->type == Type::Name;
    std::map<std::string, Place> seen;
    std::vector<DataPtr> entries;
    Checked checked{{yaml.place, {}}, {}};
    checked.resolved.kind = Kind::List;
    for (std::size_t i = 0; i < yaml.items.size(); ++i) {
      const YamlValue* name = named ? yaml.items[i].find("name") : nullptr;
      const bool good = name != nullptr && parse_name(*name).wrong.empty();
      if (name == nullptr && key.or_list && yaml.items[i].kind == Kind::Mapping) {
        report(yaml.items[i].place, join_path(path, std::to_string(i)),
               "has no name. Each of several needs one: name: …");
      }
      const std::string entry_path = join_path(path, good ? name->text : std::to_string(i));
      if (good) {
        const auto [first, is_new] = seen.emplace(name->text, name->place);
        if (!is_new) {
          refuse(*name, join_path(path, std::to_string(i) + ".name"),
                 fmt::format("'{}' is already the name of another entry at {}. Names must differ.",
                             name->text, first->second.text()));
        }
      }
      Validated entry = mapping(yaml.items[i], key.section, entry_path);
      entries.push_back(std::move(entry.data));
      checked.resolved.items.push_back(std::move(entry.resolved));
    }
    checked.value.content = std::move(entries);
    return checked;
  }

  void run_check(const Section& section, const DataPtr& data) {
    try {
      section.check(Node(data));
    } catch (const DefectError& error) {
      report(error.defect().place, error.defect().key, error.defect().text);
    } catch (const Error& error) {
      report(data->place, data->path_name, error.what());
    }
  }

  std::filesystem::path folder_;
  UnknownKeys unknown_;
  std::vector<Defect>& defects_;
  std::size_t faults_ = 0;  // defects and values that the parser refused
};

}  // namespace

Validated validate(const YamlValue& root, std::shared_ptr<const Section> table,
                   const std::filesystem::path& folder, UnknownKeys unknown,
                   std::vector<Defect>& defects) {
  return Validator(folder, unknown, defects).mapping(root, table, "");
}

}  // namespace tandem::scenario
