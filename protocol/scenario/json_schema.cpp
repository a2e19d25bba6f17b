#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "protocol/scenario/key_text.h"
#include "protocol/scenario/scenario_file.h"
#include "protocol/scenario/yaml_tree.h"

namespace tandem::scenario {
namespace {

using Json = nlohmann::ordered_json;

Json object_schema(const Section& section);

Json number(const Key& key, double value) {
  return key.type == Type::Integer ? Json(static_cast<std::int64_t>(value)) : Json(value);
}

Json default_json(const YamlValue& yaml, const Key& key) {
  switch (yaml.kind) {
    case YamlValue::Kind::List: {
      Json list = Json::array();
      for (const YamlValue& item : yaml.items) list.push_back(default_json(item, key));
      return list;
    }
    case YamlValue::Kind::Mapping: {
      Json object = Json::object();
      for (const YamlEntry& entry : yaml.entries) {
        object[entry.key] = default_json(entry.value, key);
      }
      return object;
    }
    default:
      break;
  }
  // Numbers and booleans are written in YAML as in JSON; everything else is text.
  const bool is_text = yaml.quoted || key.type == Type::Text || key.type == Type::Name ||
                       key.type == Type::Choice || key.type == Type::Path ||
                       key.type == Type::Names;
  if (!is_text && Json::accept(yaml.text)) return Json::parse(yaml.text);
  return yaml.text;
}

void add_range(Json& schema, const Key& key) {
  if (std::isfinite(key.min)) {
    schema[key.min_open ? "exclusiveMinimum" : "minimum"] = number(key, key.min);
  }
  if (std::isfinite(key.max)) {
    schema[key.max_open ? "exclusiveMaximum" : "maximum"] = number(key, key.max);
  }
}

Json array_of(Json items, const Key& key) {
  Json schema = {{"type", "array"}, {"items", std::move(items)}};
  if (key.min_count > 0) schema["minItems"] = key.min_count;
  if (key.max_count != Key{}.max_count) schema["maxItems"] = key.max_count;
  return schema;
}

/// A list in place of one mapping, which stands beside it: its entries need names. Of keys of the
/// root alone.
Json list_schema(const Key& key) {
  const Json one = {{"$ref", fmt::format("#/properties/{}/anyOf/0", key.name)}};
  const Json named = {{"required", {"name"}}};
  return {{"type", "array"}, {"items", {{"allOf", Json::array({one, named})}}}, {"minItems", 1}};
}

Json type_schema(const Key& key) {
  const Json name = {{"type", "string"}, {"pattern", "^[A-Za-z][A-Za-z0-9_]*$"}};
  Json real = {{"type", "number"}};
  add_range(real, key);
  switch (key.type) {
    case Type::Real:
      return real;
    case Type::Integer:
      real["type"] = "integer";
      return real;
    case Type::Boolean:
      return {{"type", "boolean"}};
    case Type::Text:
      return {{"type", "string"}};
    case Type::Name:
      return name;
    case Type::Choice:
      return {{"enum", key.choices}};
    case Type::Path:
      return {{"type", "string"}, {"minLength", 1}};
    case Type::Reals:
      return array_of(real, key);
    case Type::Names:
      return array_of(key.any_text ? Json{{"type", "string"}, {"minLength", 1}} : name, key);
    case Type::Section:
      if (!key.or_list) return object_schema(*key.section);
      return {{"anyOf", Json::array({object_schema(*key.section), list_schema(key)})}};
    case Type::Sections:
      return array_of(object_schema(*key.section), key);
  }
  throw std::logic_error("type of key without a schema");
}

Json key_schema(const Key& key) {
  Json schema = type_schema(key);
  schema["description"] =
      key.unit.empty() ? key.doc : fmt::format("{} Unit: {}.", key.doc, key.unit);
  if (key.default_text) {
    std::vector<Defect> defects;
    const auto yaml = parse_yaml_at(*key.default_text, {"the table", 0, 0}, defects);
    if (!yaml) throw std::logic_error("bad default in the table: " + *key.default_text);
    schema["default"] = default_json(*yaml, key);
  }
  return schema;
}

/// "if kind is ramp then end_s is required else end_s is refused", for one conditional row.
Json condition(const Key& key, const Section& section) {
  Json is_kind = {{"properties", {{key.when_key, {{"enum", key.when_values}}}}}};
  for (const Key& other : section.keys) {
    // Left out, the Choice has its default: then "properties" alone gives the right answer only
    // if the default is among the values.
    if (other.name != key.when_key) continue;
    const bool by_default =
        other.default_text &&
        std::ranges::find(key.when_values, *other.default_text) != key.when_values.end();
    if (!by_default) is_kind["required"] = {key.when_key};
  }
  Json rule = {{"if", is_kind}};
  if (key.required) rule["then"] = {{"required", {key.name}}};
  rule["else"] = {{"properties", {{key.name, false}}}};
  return rule;
}

Json object_schema(const Section& section) {
  Json properties = Json::object();
  Json required = Json::array();
  Json rules = Json::array();
  for (const Key& key : section.keys) {
    properties[key.name] = key_schema(key);
    if (!key.when_key.empty()) {
      rules.push_back(condition(key, section));
    } else if (key.required) {
      required.push_back(key.name);
    }
  }
  Json schema = {{"type", "object"}, {"properties", std::move(properties)}};
  if (!required.empty()) schema["required"] = std::move(required);
  schema["additionalProperties"] = false;
  if (!rules.empty()) schema["allOf"] = std::move(rules);
  if (section.shorthand.empty()) return schema;
  Json plain = schema["properties"][section.shorthand];
  return {{"anyOf", Json::array({std::move(plain), std::move(schema)})}};
}

}  // namespace

std::string json_schema(const Section& table, const std::string& title) {
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", title}};
  if (!table.doc.empty()) schema["description"] = table.doc;
  schema.update(object_schema(table));
  return schema.dump(2) + "\n";
}

}  // namespace tandem::scenario
