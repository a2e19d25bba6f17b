#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tandem::scenario {

struct Section;

/// What a scenario key may hold.
enum class Type {
  Real,      ///< finite number; also a list of them when `count` is set
  Integer,   ///< whole number
  Boolean,   ///< true | false (YAML 1.1's yes/no/on/off are refused: `no` is too easily a name)
  Text,      ///< free text
  Name,      ///< [A-Za-z][A-Za-z0-9_]*: an identifier that other keys and channel names refer to
  Choice,    ///< one of `choices`
  Path,      ///< file relative to the scenario file
  Reals,     ///< list of numbers, `min_count` … `max_count` of them
  Names,     ///< list of names
  Section,   ///< a mapping described by `section`
  Sections,  ///< a list of mappings, each described by `section`
};

/// One row of the table that validation, the resolved scenario, the JSON Schema and the reference
/// page are all made from. Units are part of the name (`macro_step_s`) and repeated in `unit` for
/// the reader.
struct Key {
  std::string name;
  Type type = Type::Real;
  std::string unit;  ///< "s", "m", … ; empty = dimensionless
  std::string doc;   ///< one or two sentences; starts with a capital, ends with a full stop
  bool required = false;
  std::optional<std::string>
      default_text;  ///< YAML text; absent and not required = may be left out
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_open = false;  ///< true: value > min, false: value ≥ min
  bool max_open = false;
  std::size_t min_count = 0;
  std::size_t max_count = std::numeric_limits<std::size_t>::max();
  std::vector<std::string> choices;
  std::shared_ptr<const Section> section;

  // Builders, so that a table reads as a table:
  //   real("erp", "").doc_is("…").between(0, 1).by_default("0.2")
  Key& doc_is(std::string text);
  Key& must();  ///< required
  Key& by_default(std::string yaml_text);
  Key& above(double bound);               ///< value > bound
  Key& at_least(double bound);            ///< value ≥ bound
  Key& between(double low, double high);  ///< low ≤ value ≤ high
  Key& below(double bound);               ///< value < bound
  Key& count(std::size_t n);              ///< Reals: exactly n
  Key& count(std::size_t low, std::size_t high);
};

struct Section {
  std::string title;  ///< heading on the reference page
  std::string doc;
  std::vector<Key> keys;
};

[[nodiscard]] Key real(std::string name, std::string unit);
[[nodiscard]] Key integer(std::string name);
[[nodiscard]] Key boolean(std::string name);
[[nodiscard]] Key text(std::string name);
[[nodiscard]] Key name(std::string key_name);
[[nodiscard]] Key choice(std::string name, std::vector<std::string> choices);
[[nodiscard]] Key path(std::string name);
[[nodiscard]] Key reals(std::string name, std::string unit);
[[nodiscard]] Key names(std::string name);
[[nodiscard]] Key section(std::string name, Section content);
[[nodiscard]] Key sections(std::string name, Section content);

}  // namespace tandem::scenario
