#include "protocol/scenario/key_table.h"

#include <utility>

namespace tandem::scenario {
namespace {

Key key_of(std::string name, Type type) {
  Key key;
  key.name = std::move(name);
  key.type = type;
  return key;
}

}  // namespace

Key& Key::doc_is(std::string text) {
  doc = std::move(text);
  return *this;
}

Key& Key::must() {
  required = true;
  return *this;
}

Key& Key::by_default(std::string yaml_text) {
  default_text = std::move(yaml_text);
  return *this;
}

Key& Key::above(double bound) {
  min = bound;
  min_open = true;
  return *this;
}

Key& Key::at_least(double bound) {
  min = bound;
  min_open = false;
  return *this;
}

Key& Key::between(double low, double high) {
  min = low;
  max = high;
  min_open = max_open = false;
  return *this;
}

Key& Key::below(double bound) {
  max = bound;
  max_open = true;
  return *this;
}

Key& Key::count(std::size_t n) { return count(n, n); }

Key& Key::count(std::size_t low, std::size_t high) {
  min_count = low;
  max_count = high;
  return *this;
}

Key& Key::at_least_count(std::size_t low) {
  min_count = low;
  return *this;
}

Key& Key::of_unit_length() {
  unit_length = true;
  return *this;
}

Key& Key::of_any_text() {
  any_text = true;
  return *this;
}

Key& Key::or_several() {
  or_list = true;
  return *this;
}

Key& Key::only_when(std::string key, std::vector<std::string> values) {
  when_key = std::move(key);
  when_values = std::move(values);
  return *this;
}

Key real(std::string name, std::string unit) {
  Key key = key_of(std::move(name), Type::Real);
  key.unit = std::move(unit);
  return key;
}

Key integer(std::string name) { return key_of(std::move(name), Type::Integer); }

Key boolean(std::string name) { return key_of(std::move(name), Type::Boolean); }

Key text(std::string name) { return key_of(std::move(name), Type::Text); }

Key name(std::string key_name) { return key_of(std::move(key_name), Type::Name); }

Key choice(std::string name, std::vector<std::string> choices) {
  Key key = key_of(std::move(name), Type::Choice);
  key.choices = std::move(choices);
  return key;
}

Key path(std::string name) { return key_of(std::move(name), Type::Path); }

Key reals(std::string name, std::string unit) {
  Key key = key_of(std::move(name), Type::Reals);
  key.unit = std::move(unit);
  return key;
}

Key names(std::string name) { return key_of(std::move(name), Type::Names); }

Key section(std::string name, Section content) {
  Key key = key_of(std::move(name), Type::Section);
  key.section = std::make_shared<const Section>(std::move(content));
  return key;
}

Key sections(std::string name, Section content) {
  Key key = key_of(std::move(name), Type::Sections);
  key.section = std::make_shared<const Section>(std::move(content));
  return key;
}

}  // namespace tandem::scenario
