#include "tests/unit/scenario/support.h"

namespace tandem::scenario {
namespace {

Section table() {
  Section body;
  body.title = "Body";
  body.keys = {name("name").must(), real("mass_kg", "kg").must().above(0),
               reals("position_m", "m").count(3), real("v_x_m_per_s", "m/s")};
  Section solver;
  solver.title = "Solver";
  solver.keys = {choice("scheme", {"explicit_serial", "implicit"}).by_default("implicit"),
                 real("erp", "").between(0, 1),
                 real("relaxation", "").above(0).below(2),
                 integer("max_iterations").at_least(1),
                 boolean("accept"),
                 names("sets").count(1, 2),
                 path("mesh")};
  Section root;
  root.title = "Test";
  root.keys = {real("macro_step_s", "s").must().above(0), sections("bodies", body),
               section("solver", solver)};
  return root;
}

void expect_one(const std::string& text, const std::string& line) {
  expect_defect(text, table(), line);
}

TEST(ScenarioDefect, GoodFileHasNone) {
  EXPECT_TRUE(defects_of("macro_step_s: 1e-3\nbodies: [{name: a, mass_kg: 1}]\n", table()).empty());
}

TEST(ScenarioDefect, AllAreReportedAtOnceInTheOrderOfTheFile) {
  const std::vector<std::string> expected = {
      "scenario.yaml:1:15: macro_step_s: 0 is out of range. It must be > 0 s.",
      "scenario.yaml:2:1: solvr: is not a key here. Did you mean 'solver'?",
      "scenario.yaml:4:5: bodies.a.mass_kg: is missing. Give a number in kg.",
      "scenario.yaml:5:21: bodies.a.position_m.1: 'y' is not a number. Write a number like 0.001 "
      "or 1e-3."};
  EXPECT_EQ(defects_of("macro_step_s: 0\nsolvr: {}\nbodies:\n  - name: a\n"
                       "    position_m: [1, y, 2]\n",
                       table()),
            expected)
      << "columns count from 1";
}

TEST(ScenarioDefect, UnknownKeyIsComparedWithTheKeysOfItsSection) {
  expect_one("macro_step_s: 1\nsolver:\n  max_iteration: 3\n",
             "scenario.yaml:3:3: solver.max_iteration: is not a key here. Did you mean "
             "'max_iterations'?");
  expect_one("macro_step_s: 1\nsolver:\n  shceme: implicit\n",
             "scenario.yaml:3:3: solver.shceme: is not a key here. Did you mean 'scheme'?");
  expect_one("macro_step_s: 1\nqqq: 2\n",
             "scenario.yaml:2:1: qqq: is not a key here. Keys here: macro_step_s, bodies, solver.");
}

TEST(ScenarioDefect, WrongUnitInTheNameLeadsToTheRightOne) {
  const std::string remedy = "is not a key here. Did you mean 'macro_step_s' (s)?";
  expect_one("macro_step_ms: 1\n", "scenario.yaml:1:1: macro_step_ms: " + remedy);
  expect_one("macro_step: 1\n", "scenario.yaml:1:1: macro_step: " + remedy);
  expect_one(
      "macro_step_s: 1\nbodies:\n- {name: a, mass_g: 5}\n",
      "scenario.yaml:3:13: bodies.a.mass_g: is not a key here. Did you mean 'mass_kg' (kg)?");
  expect_one("macro_step_s: 1\nbodies:\n- {name: a, mass_kg: 5, v_x_mm_per_s: 2}\n",
             "scenario.yaml:3:25: bodies.a.v_x_mm_per_s: is not a key here. Did you mean "
             "'v_x_m_per_s' (m/s)?");
}

TEST(ScenarioDefect, DuplicateKeyNamesBothPlaces) {
  expect_one("macro_step_s: 1\nbodies: []\nmacro_step_s: 2\n",
             "scenario.yaml:3:1: macro_step_s: is given twice; the first is at scenario.yaml:1:1. "
             "Remove one of the two.");
}

TEST(ScenarioDefect, DuplicateNameNamesBothPlaces) {
  expect_one("macro_step_s: 1\nbodies:\n- {name: a, mass_kg: 5}\n- {name: a, mass_kg: 5}\n",
             "scenario.yaml:4:10: bodies.1.name: 'a' is already the name of another entry at "
             "scenario.yaml:3:10. Names must differ.");
}

TEST(ScenarioDefect, TabIsReportedWhereItStands) {
  expect_one("macro_step_s: 1\nsolver:\n  # fine\n\t\n \terp: 0\n",
             "scenario.yaml:5:2: a tab is used for indentation. Indent with spaces.");
}

TEST(ScenarioDefect, TabInsideABlockOfTextIsText) {
  Section root;
  root.keys = {text("description"), integer("n")};
  const Loaded loaded = load_text("description: |\n  a\n  \tb\nn: 1\n", root);
  EXPECT_EQ(loaded.root.text("description"), "a\n\tb\n");
  EXPECT_EQ(defects_of("description: |\n  a\n  \tb\n\tn: 1\n", root).size(), 1U);
}

TEST(ScenarioDefect, BrokenYamlIsReportedWithItsPlace) {
  expect_one(
      "macro_step_s: 1\nbodies: [{name: a\nsolver: {}\n",
      "scenario.yaml:3:7: is not YAML here: end of map flow not found. Check indentation, ':' and "
      "brackets.");
}

TEST(ScenarioDefect, SecondDocumentIsRefused) {
  const std::string text =
      " a second document ('---') or a stray character stands here. A scenario is one mapping; "
      "indent what belongs to it.";
  expect_one("macro_step_s: 1\n---\nmacro_step_s: 2\n", "scenario.yaml:2:1:" + text);
  // Before such a comma the parser alone finds empty documents for ever.
  expect_one(",macro_step_s: 1\n", "scenario.yaml:1:1:" + text);
}

TEST(ScenarioDefect, AnchorsAliasesMergesAndTagsAreRefused) {
  const std::vector<std::string> expected = {
      "scenario.yaml:2:9: bodies: anchors (&name) are not supported. Write the value out at each "
      "place.",
      "scenario.yaml:3:9: solver: aliases (*name) are not supported. Write the value out."};
  EXPECT_EQ(defects_of("macro_step_s: 1\nbodies: &b []\nsolver: *b\n", table()), expected);
  expect_one("macro_step_s: 1\nsolver:\n  <<: {erp: 0}\n",
             "scenario.yaml:3:3: solver.<<: merge keys are not supported. Write the merged keys "
             "out.");
  expect_one("macro_step_s: !!float 1\n",
             "scenario.yaml:1:15: macro_step_s: the tag tag:yaml.org,2002:float is not supported. "
             "Write plain values.");
}

TEST(ScenarioDefect, BooleansAreTrueOrFalseOnly) {
  for (const std::string word : {"yes", "on", "y", "True", "\"true\""}) {
    const std::string bare = word == "\"true\"" ? "true" : word;
    expect_one(
        "macro_step_s: 1\nsolver: {accept: " + word + "}\n",
        "scenario.yaml:2:18: solver.accept: '" + bare + "' is neither true nor false. Write true.");
  }
  for (const std::string word : {"no", "off", "FALSE"}) {
    expect_one("macro_step_s: 1\nsolver: {accept: " + word + "}\n",
               "scenario.yaml:2:18: solver.accept: '" + word +
                   "' is neither true nor false. Write false.");
  }
}

TEST(ScenarioDefect, NumbersAreFiniteAndPlain) {
  const auto claim = [](const std::string& value, const std::string& text) {
    expect_one("macro_step_s: " + value + "\n", "scenario.yaml:1:15: macro_step_s: " + text);
  };
  for (const std::string word : {".nan", "NaN", "inf", "-.inf", "+.Inf", "Infinity"}) {
    claim(word, "is " + word + ". Write a finite number.");
  }
  for (const std::string value : {"1 ms", "5mm", "1e-3 s", "2 µs", "3%"}) {
    claim(value, "'" + value +
                     "' carries a unit. Values are plain numbers in the unit that the key's name "
                     "states; this one is in s.");
  }
  claim("0,5", "'0,5' is not a number. Write a decimal point, not a comma.");
  claim("1/3", "'1/3' is not a number. Write a number like 0.001 or 1e-3.");
  claim("\"1\"", "is text (\"1\"). Write a number without quotes.");
  claim("1e999", "1e999 is beyond what a double can hold (2e-308 … 1e308).");
  claim("{}", "is a mapping of keys to values. It must be a number.");
  claim("[1]", "is a list. It must be a number.");
}

TEST(ScenarioDefect, MissingValueStandsAtItsKey) {
  expect_one("macro_step_s:\n\nsolver: {}\n",
             "scenario.yaml:1:1: macro_step_s: has no value. It must be a number.");
}

TEST(ScenarioDefect, RangesStateTheirBounds) {
  const auto claim = [](const std::string& entry, const std::string& line) {
    expect_one("macro_step_s: 1\nsolver: {" + entry + "}\n", "scenario.yaml:2:" + line);
  };
  claim("erp: 1.5", "15: solver.erp: 1.5 is out of range. It must be 0 … 1.");
  claim("relaxation: 2", "22: solver.relaxation: 2 is out of range. It must be > 0 and < 2.");
  claim("max_iterations: 0", "26: solver.max_iterations: 0 is out of range. It must be ≥ 1.");
  claim("max_iterations: 99999999999999999999",
        "26: solver.max_iterations: 99999999999999999999 is beyond what a whole number can be "
        "here: -2147483648 … 2147483647.");
  // Kept in 32 bits it would be 1.
  claim("max_iterations: 4294967297",
        "26: solver.max_iterations: 4294967297 is beyond what a whole number can be here: "
        "-2147483648 … 2147483647.");
  claim("max_iterations: 1e3",
        "26: solver.max_iterations: '1e3' is not a whole number. Write a whole number like 10.");
  claim("sets: []", "16: solver.sets: has 0 entries. It must be a list of 1 … 2 names.");
  claim("sets: [a, 2]",
        "20: solver.sets.1: '2' is not a name. Begin with a letter, then use letters, digits and "
        "'_' only.");
  claim("mesh: \"\"", "16: solver.mesh: is empty. Give a file name.");
  claim("scheme: explicit",
        "18: solver.scheme: 'explicit' is not known. It must be one of explicit_serial, implicit. "
        "Did you mean 'explicit_serial'?");
}

TEST(ScenarioDefect, ListAndMappingAreNotInterchangeable) {
  expect_one("macro_step_s: 1\nbodies: {name: a}\n",
             "scenario.yaml:2:9: bodies: is a mapping of keys to values. It must be a list of "
             "mappings.");
  expect_one("macro_step_s: 1\nsolver: [a]\n",
             "scenario.yaml:2:9: solver: is a list. It must be a mapping of keys to values.");
  expect_one("macro_step_s: 1\nbodies: [5]\n",
             "scenario.yaml:2:10: bodies.0: '5' is a single value. It must be a mapping of keys to "
             "values.");
}

TEST(ScenarioDefect, MissingKeyStandsAtTheMappingThatLacksIt) {
  expect_one("bodies: []\n", "scenario.yaml:1:1: macro_step_s: is missing. Give a number in s.");
}

TEST(ScenarioDefect, TopOfTheFileIsAMapping) {
  const std::string empty =
      "scenario.yaml:1:1: the file is empty. A scenario is a mapping of keys to values.";
  expect_one("", empty);
  expect_one("# only a comment\n", empty);
  const std::string remedy =
      " the file holds no mapping at its top. A scenario is a mapping of keys to values, 'name: …' "
      "first.";
  expect_one("- a\n", "scenario.yaml:1:1:" + remedy);
  expect_one("\nhello\n", "scenario.yaml:2:1:" + remedy);
}

TEST(ScenarioDefect, FileMustBeThereAndReadable) {
  const ScenarioFile file("macro_step_s: 1\n");
  const auto claim = [](const std::filesystem::path& path, const std::string& words) {
    try {
      (void)load(path, table());
      ADD_FAILURE() << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Usage);
      EXPECT_EQ(error.what(), path.string() + ": " + words);
    }
  };
  claim(file.folder() / "other.yaml",
        "there is no such file. Check the name and the working directory.");
  claim(file.folder(), "is a directory. Give the scenario file in it, for example " +
                           (file.folder() / "scenario.yaml").string() + ".");
  // Opens for everybody, but nothing is mapped at its beginning: reading fails.
  claim("/proc/self/mem", "cannot be read (Input/output error). Check its permissions.");
}

TEST(ScenarioDefect, ReadersReportAtThePlaceOfTheirKey) {
  const ScenarioFile file("macro_step_s: 1\nbodies:\n- {name: a, mass_kg: 5}\n");
  const Loaded loaded = load(file.path(), table());
  const Node body = loaded.root.list("bodies").front();
  const auto what = [&](const std::string& key) {
    try {
      body.fail(key, "is bad.");
    } catch (const Error& error) {
      return std::string(error.what());
    }
  };
  EXPECT_EQ(what("mass_kg"), file.path().string() + ":3:22: bodies.a.mass_kg: is bad.");
  EXPECT_EQ(what("position_m"), file.path().string() + ":3:3: bodies.a.position_m: is bad.");
}

TEST(ScenarioDefect, AskingOutsideTheTableIsADefectOfTheReader) {
  const Loaded loaded = load_text("macro_step_s: 1\n", table());
  EXPECT_THROW((void)loaded.root.real("mass_kg"), std::logic_error);
  EXPECT_THROW((void)loaded.root.has("mass_kg"), std::logic_error);
  EXPECT_THROW((void)loaded.root.integer("macro_step_s"), std::logic_error);
  EXPECT_FALSE(loaded.root.has("solver"));
  EXPECT_THROW((void)loaded.root.section("solver"), std::logic_error);
}

}  // namespace
}  // namespace tandem::scenario
