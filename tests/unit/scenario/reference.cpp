#include <nlohmann/json.hpp>

#include "protocol/scenario/law.h"
#include "tests/unit/scenario/support.h"

namespace tandem::scenario {
namespace {

Section table() {
  Section body;
  body.title = "Body";
  body.doc = "A rigid body.";
  body.keys = {
      name("name").must().doc_is("Its name."),
      real("mass_kg", "kg").must().above(0).doc_is("Mass."),
      reals("position_m", "m").count(3).by_default("[0, 0, 0.5]").doc_is("Position."),
      law("force_N", "N").by_default("0").doc_is("Force along x."),
  };
  Section root;
  root.title = "Scenario";
  root.doc = "A test.";
  root.keys = {
      choice("scheme", {"a", "b"}).by_default("b").doc_is("Scheme a|b."),
      integer("steps").between(1, 9).doc_is("Steps."),
      boolean("accept").by_default("true").doc_is("Accept."),
      path("mesh").doc_is("Mesh."),
      names("sets").at_least_count(1).doc_is("Sets."),
      sections("bodies", body).must().at_least_count(1).doc_is("Bodies."),
  };
  return root;
}

using nlohmann::json;

TEST(JsonSchema, SaysWhatTheTableSays) {
  const json schema = json::parse(json_schema(table(), "Test scenario"));
  EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
  EXPECT_EQ(schema["title"], "Test scenario");
  EXPECT_EQ(schema["description"], "A test.");
  EXPECT_EQ(schema["type"], "object");
  EXPECT_EQ(schema["additionalProperties"], false);
  EXPECT_EQ(schema["required"], json::parse(R"(["bodies"])"));
  const json& keys = schema["properties"];
  EXPECT_EQ(keys["scheme"],
            json::parse(R"({"enum": ["a", "b"], "description": "Scheme a|b.", "default": "b"})"));
  EXPECT_EQ(keys["steps"], json::parse(R"({"type": "integer", "minimum": 1, "maximum": 9,
                                           "description": "Steps."})"));
  EXPECT_EQ(keys["accept"],
            json::parse(R"({"type": "boolean", "description": "Accept.", "default": true})"));
  EXPECT_EQ(keys["mesh"],
            json::parse(R"({"type": "string", "minLength": 1, "description": "Mesh."})"));
  EXPECT_EQ(keys["sets"], json::parse(R"({"type": "array", "minItems": 1, "description": "Sets.",
              "items": {"type": "string", "pattern": "^[A-Za-z][A-Za-z0-9_]*$"}})"));
  EXPECT_EQ(keys["bodies"]["minItems"], 1);
  const json& body = keys["bodies"]["items"];
  EXPECT_EQ(body["additionalProperties"], false);
  EXPECT_EQ(body["required"], json::parse(R"(["name", "mass_kg"])"));
  EXPECT_EQ(body["properties"]["mass_kg"], json::parse(R"({"type": "number", "exclusiveMinimum": 0,
                            "description": "Mass. Unit: kg."})"));
  EXPECT_EQ(body["properties"]["position_m"],
            json::parse(R"({"type": "array", "items": {"type": "number"}, "minItems": 3,
                            "maxItems": 3, "default": [0, 0, 0.5],
                            "description": "Position. Unit: m."})"));
}

TEST(JsonSchema, LawIsANumberOrAMappingWhoseKeysDependOnItsKind) {
  const json schema = json::parse(json_schema(table(), "Test scenario"));
  const json& law = schema["properties"]["bodies"]["items"]["properties"]["force_N"];
  EXPECT_EQ(law["default"], 0);
  ASSERT_EQ(law["anyOf"].size(), 2U);
  EXPECT_EQ(law["anyOf"][0]["type"], "number");
  const json& mapping = law["anyOf"][1];
  EXPECT_EQ(mapping["additionalProperties"], false);
  EXPECT_FALSE(mapping.contains("required"));
  // `value` belongs to the default kind: the rule also holds where kind is left out.
  EXPECT_EQ(mapping["allOf"][0],
            json::parse(R"({"if": {"properties": {"kind": {"enum": ["constant"]}}},
                            "then": {"required": ["value"]},
                            "else": {"properties": {"value": false}}})"));
  EXPECT_EQ(mapping["allOf"][2], json::parse(R"({"if": {"properties": {"kind": {"enum": ["ramp"]}},
                                   "required": ["kind"]},
                            "then": {"required": ["end_s"]},
                            "else": {"properties": {"end_s": false}}})"));
}

TEST(ReferencePage, HasOneTablePerSectionAndSharedSectionsOnce) {
  const std::string page = reference_markdown(table(), "Scenario keys");
  const std::string expected_start = R"(# Scenario keys

## Scenario

A test.

| key | type | unit | range | default | meaning |
|---|---|---|---|---|---|
| `scheme` | one of a, b | – | – | `b` | Scheme a\|b. |
| `steps` | a whole number | – | 1 … 9 | – | Steps. |
| `accept` | true or false | – | – | `true` | Accept. |
| `mesh` | a file name | – | – | – | Mesh. |
| `sets` | a list of at least 1 name | – | – | – | Sets. |
| `bodies` | list of at least 1 [Body](#body-bodies) | – | – | required | Bodies. |

## Body (bodies[])

A rigid body.

| key | type | unit | range | default | meaning |
|---|---|---|---|---|---|
| `name` | a name (a letter, then letters, digits and '_') | – | – | required | Its name. |
| `mass_kg` | a number | kg | > 0 | required | Mass. |
| `position_m` | a list of exactly 3 numbers | m | – | `[0, 0, 0.5]` | Position. |
| `force_N` | [Law](#law) | N | – | `0` | Force along x. |

## Law

)";
  EXPECT_EQ(page.substr(0, expected_start.size()), expected_start);
  EXPECT_NE(page.find("| `value` | a number | of the holding key | – | required | Value at all "
                      "times. Only when `kind` is constant. |"),
            std::string::npos)
      << page;
  EXPECT_NE(page.find("| `begin_s` | a number | s |"), std::string::npos);
}

}  // namespace
}  // namespace tandem::scenario
