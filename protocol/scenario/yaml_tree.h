#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/scenario/node.h"

namespace tandem::scenario {

struct YamlEntry;

/// A YAML document as it stands in the file: no types yet, every value with its place.
struct YamlValue {
  enum class Kind {
    Null,
    Scalar,
    List,
    Mapping,
    Refused,  ///< reported as a defect already; nothing more is to be said about it
  };
  Kind kind = Kind::Null;
  Place place;
  std::string text;     ///< Scalar
  bool quoted = false;  ///< Scalar in '…' or "…" (or a block scalar): always text
  std::vector<YamlValue> items;
  std::vector<YamlEntry> entries;

  [[nodiscard]] YamlValue* find(std::string_view key);
  [[nodiscard]] const YamlValue* find(std::string_view key) const;
};

struct YamlEntry {
  std::string key;
  Place place;  ///< of the key
  YamlValue value;
};

/// One thing wrong with a scenario.
struct Defect {
  Place place;
  std::string key;   ///< path name, "" for the file as a whole
  std::string text;  ///< "what is wrong. What would be right."
};

/// Parses one document. Tabs, syntax errors, anchors, aliases, `<<`, tags and duplicate keys (the
/// first one stays) are added to `defects`. Nothing is returned when the rest cannot be read.
[[nodiscard]] std::optional<YamlValue> parse_yaml(const std::string& text, const std::string& file,
                                                  std::vector<Defect>& defects);
/// The same for text outside a file (--set values, defaults): everything stands at `place`.
[[nodiscard]] std::optional<YamlValue> parse_yaml_at(const std::string& text, const Place& place,
                                                     std::vector<Defect>& defects);

/// A scalar with this text at this place.
[[nodiscard]] YamlValue yaml_scalar(std::string text, bool quoted, const Place& place);

/// YAML text: mappings as blocks, lists of scalars in one line. Equal trees give equal text.
[[nodiscard]] std::string to_yaml(const YamlValue& mapping);

}  // namespace tandem::scenario
