#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tandem::scenario {

class Node;
struct Section;

/// What a scenario key may hold.
enum class Type {
  Real,      ///< finite number
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
  bool unit_length = false;  ///< Reals: Euclidean norm is 1 within 1e-3
  bool any_text = false;     ///< Names: of another file, which has its own rules for them
  bool or_list = false;      ///< Section: a list of such mappings, each with a `name`, as well

  /// The key belongs to some values of a sibling Choice only (`begin_s` to `kind: ramp`): elsewhere
  /// it is refused and has no default. `when_key` empty = always.
  std::string when_key;
  std::vector<std::string> when_values;

  // Builders, so that a table reads as a table:
  //   real("erp", "").doc_is("…").between(0, 1).by_default("0.2")
  Key& doc_is(std::string text);
  Key& must();  ///< required
  Key& by_default(std::string yaml_text);
  Key& above(double bound);               ///< value > bound
  Key& at_least(double bound);            ///< value ≥ bound
  Key& between(double low, double high);  ///< low ≤ value ≤ high
  Key& below(double bound);               ///< value < bound
  Key& count(std::size_t n);              ///< Reals, Names, Sections: exactly n
  Key& count(std::size_t low, std::size_t high);
  Key& at_least_count(std::size_t low);
  Key& of_unit_length();  ///< Reals: a direction or a quaternion
  Key& of_any_text();     ///< Names: any text that is not empty
  Key& or_several();      ///< Section: a list of named ones may stand in its place
  Key& only_when(std::string key, std::vector<std::string> values);
};

struct Section {
  std::string title;  ///< heading on the reference page
  std::string doc;
  std::vector<Key> keys;
  /// Key that a plain value stands for: `torque_Nm: 3` is short for `torque_Nm: {value: 3}`.
  std::string shorthand;
  /// What the rows cannot say one by one (lists of equal length, a < b). Called while loading for
  /// every mapping whose keys are good; says what is wrong through Node::fail(), so that it is
  /// reported together with all other defects of the file.
  std::function<void(const Node&)> check;
  bool shared = false;  ///< used under many keys: described once on the reference page
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
/// A list of mappings. When `content` has a key `name` of type Name, the names must differ, and
/// errors and --set call the entries by them.
[[nodiscard]] Key sections(std::string name, Section content);

}  // namespace tandem::scenario
