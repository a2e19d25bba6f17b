#include "protocol/scenario/law.h"
#include "tests/unit/scenario/support.h"

namespace tandem::scenario {
namespace {

Section table() {
  Section body;
  body.title = "Body";
  body.keys = {name("name").must(), real("mass_kg", "kg").must().above(0),
               reals("position_m", "m").count(3), law("force_N", "N")};
  Section solver;
  solver.title = "Solver";
  solver.keys = {choice("scheme", {"explicit_serial", "implicit"}).by_default("implicit"),
                 integer("steps").by_default("1")};
  Section root;
  root.title = "Test";
  root.keys = {text("title").must(), sections("bodies", body),
               section("solver", solver).by_default("{}")};
  return root;
}

const char* const kText =
    "title: a\nbodies:\n- {name: crank, mass_kg: 1, force_N: 3, position_m: [0, 0, 0]}\n"
    "- {name: rod, mass_kg: 2}\n";

Loaded with(const std::vector<std::string>& arguments) {
  std::vector<Override> changes;
  for (const std::string& argument : arguments) changes.push_back(parse_override(argument));
  return load_text(kText, table(), changes);
}

void expect_refused(const std::string& argument, const std::string& words) {
  EXPECT_EQ(defects_of(kText, table(), {parse_override(argument)}),
            std::vector<std::string>{"--set " + argument + ": " + words});
}

TEST(Override, ReplacesAValue) { EXPECT_EQ(with({"title=b c"}).root.text("title"), "b c"); }

TEST(Override, CreatesKeysAndSectionsThatTheFileLeavesOut) {
  const Loaded loaded = with({"solver.steps=5", "bodies.rod.position_m=[1, 2, 3]"});
  EXPECT_EQ(loaded.root.section("solver").integer("steps"), 5);
  EXPECT_EQ(loaded.root.section("solver").text("scheme"), "implicit");
  EXPECT_EQ(loaded.root.list("bodies")[1].vector3("position_m"), Eigen::Vector3d(1, 2, 3));
}

TEST(Override, FindsListEntriesByNameAndByIndex) {
  const Loaded loaded =
      with({"bodies.rod.mass_kg=7", "bodies.0.mass_kg=8", "bodies.crank.position_m.2=9"});
  EXPECT_EQ(loaded.root.list("bodies")[1].real("mass_kg"), 7.0);
  EXPECT_EQ(loaded.root.list("bodies")[0].real("mass_kg"), 8.0);
  EXPECT_EQ(loaded.root.list("bodies")[0].vector3("position_m"), Eigen::Vector3d(0, 0, 9));
}

TEST(Override, LastOneWins) { EXPECT_EQ(with({"title=b", "title=c"}).root.text("title"), "c"); }

TEST(Override, ReachesIntoAShorthand) {
  EXPECT_EQ(
      read_law(with({"bodies.crank.force_N.value=4"}).root.list("bodies")[0].section("force_N"))(
          0.0),
      4.0);
}

TEST(Override, ReplacesAWholeSection) {
  EXPECT_EQ(with({"solver={scheme: explicit_serial}"}).root.section("solver").text("scheme"),
            "explicit_serial");
}

TEST(Override, BadPathsAreRefusedWithTheRemedy) {
  expect_refused("solver.step=5", "solver.step: is not a key here. Did you mean 'steps'?");
  expect_refused("solvr.steps=5", "solvr: is not a key here. Did you mean 'solver'?");
  expect_refused("bodies.crnk.mass_kg=5",
                 "bodies.crnk: names no entry of this list. Use a name or an index below 2. Did "
                 "you mean 'crank'?");
  expect_refused("bodies.2.mass_kg=5",
                 "bodies.2: names no entry of this list. Use a name or an index below 2. It has "
                 "crank, rod.");
  expect_refused("bodies.rod.mass=5",
                 "bodies.rod.mass: is not a key here. Did you mean 'mass_kg' (kg)?");
  expect_refused("title.x=5",
                 "title: is a single value; there is nothing below it. Shorten the path.");
  expect_refused(
      "bodies.rod.position_m.0=5",
      "bodies.rod.position_m: is not a list in the file. Set the whole list, [a, b, …].");
}

TEST(Override, BadValuesAreRefusedAtTheArgument) {
  expect_refused("bodies.rod.mass_kg=0",
                 "bodies.rod.mass_kg: 0 is out of range. It must be > 0 kg.");
  expect_refused("solver.steps=", "solver.steps: has no value. It must be a whole number.");
  expect_refused("solver.steps=[1",
                 "is not YAML here: end of sequence flow not found. Check indentation, ':' and "
                 "brackets.");
}

// The message names the key; of a value that fills pages it shows the beginning, cut between
// letters.
TEST(Override, LongValueIsShortenedInMessages) {
  std::string value = "x";
  for (int i = 0; i < 200; ++i) value += "é";
  const std::vector<std::string> defects =
      defects_of(kText, table(), {parse_override("solver.steps=" + value)});
  ASSERT_EQ(defects.size(), 1U);
  std::string beginning = "--set solver.steps=x";
  for (int i = 0; i < 50; ++i) beginning += "é";
  EXPECT_EQ(defects.front().substr(0, beginning.size()), beginning);
  EXPECT_NE(defects.front().find("é…: solver.steps: "), std::string::npos) << defects.front();
}

TEST(Override, ArgumentWithoutEqualsSignIsRefused) {
  EXPECT_THROW((void)parse_override("title"), Error);
  EXPECT_THROW((void)parse_override("=5"), Error);
  EXPECT_EQ(parse_override("a.b=c=d").path, "a.b");
  EXPECT_EQ(parse_override("a.b=c=d").value, "c=d");
}

}  // namespace
}  // namespace tandem::scenario
