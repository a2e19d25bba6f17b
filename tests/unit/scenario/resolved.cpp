#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/law.h"
#include "tests/unit/scenario/support.h"

namespace tandem::scenario {
namespace {

Section flexible_part() {
  Section fem;
  fem.title = "FEM";
  fem.keys = {path("mesh").must(), law("load_N", "N").by_default("0"), names("sets"),
              boolean("lumped").by_default("false")};
  return fem;
}

Section table() {
  Section root;
  root.title = "Scenario";
  root.keys = root_keys();
  root.keys.push_back(run_keys());
  root.keys.push_back(ports_keys());
  root.keys.push_back(section("fem", flexible_part()).must());
  root.keys.push_back(output_keys());
  return root;
}

/// What the flexible side knows of the table.
Section part_of_table() {
  Section root;
  root.title = "Part";
  root.keys = {run_keys(), section("fem", flexible_part()).must()};
  return root;
}

const char* const kText = R"(# comment
fem: {mesh: ../lug.msh, sets: [no, A1], load_N: {kind: table, times_s: [0, 0.1], values: [+1, 2.50]}}
name: no
description: "a: \"b\" # c\n\té"
run: {duration_s: 0.30000000000000004440892098500626, macro_step_s: 1.00e-1}
ports:
  - {name: p, body: b, node_set: "12"}
)";

TEST(ResolvedScenario, IsCompleteAndKeepsTheTextOfNumbers) {
  const ScenarioFile file(kText);
  const Loaded loaded = load(file.path(), table());
  const std::string mesh = (file.folder().parent_path() / "lug.msh").string();
  EXPECT_EQ(loaded.resolved_yaml, R"(name: "no"
description: "a: \"b\" # c\n\té"
run:
  duration_s: 0.30000000000000004440892098500626
  macro_step_s: 1.00e-1
  accuracy: 1e-6
  pace: "free"
ports:
  - name: "p"
    body: "b"
    node_set: "12"
    orientation_wxyz: [1, 0, 0, 0]
    attachment: "rigid"
fem:
  mesh: ")" + mesh + R"("
  load_N:
    kind: "table"
    times_s: [0, 0.1]
    values: [+1, 2.50]
  sets: ["no", "A1"]
  lumped: false
output:
  vtu_every_steps: 0
  bodies_every_steps: 1
  energy_every_steps: 0
  log_every_steps: 1
)");
}

TEST(ResolvedScenario, PathsAreRelativeToTheScenarioFile) {
  const ScenarioFile file(kText);
  const Loaded loaded = load(file.path(), table());
  EXPECT_EQ(loaded.root.section("fem").path("mesh"), file.folder().parent_path() / "lug.msh");
}

TEST(ResolvedScenario, GivesItselfAndItsHashAgainFromAnotherFolder) {
  const Loaded first = load_text(kText, table());
  const Loaded second = load_text(first.resolved_yaml, table());
  EXPECT_EQ(second.resolved_yaml, first.resolved_yaml);
  EXPECT_EQ(second.hash, first.hash);
  EXPECT_EQ(second.root.text("description"), "a: \"b\" # c\n\té");
}

TEST(ResolvedScenario, HashIgnoresCommentsAndOrderButNotValues) {
  const ScenarioFile file(kText);
  const std::uint64_t hash = load(file.path(), table()).hash;
  std::string text = kText;
  std::ofstream(file.path()) << "output: {}\n" << text << "# another comment\n";
  EXPECT_EQ(load(file.path(), table()).hash, hash);
  text.replace(text.find("2.50"), 4, "2.51");
  std::ofstream(file.path()) << text;
  EXPECT_NE(load(file.path(), table()).hash, hash);
}

TEST(ResolvedScenario, HasTheSameHashForAReaderOfAPartOfTheTable) {
  const Loaded whole = load_text(kText, table());
  const Loaded part = load_text(whole.resolved_yaml, part_of_table(), {}, UnknownKeys::Ignore);
  EXPECT_EQ(part.resolved_yaml, whole.resolved_yaml);
  EXPECT_EQ(part.hash, whole.hash);
  EXPECT_EQ(read_run(part.root).macro_steps(), 3);
  EXPECT_EQ(part.root.section("fem").names("sets"), (std::vector<std::string>{"no", "A1"}));
  EXPECT_THROW((void)part.root.text("name"), std::logic_error);
}

TEST(ResolvedScenario, PartReaderStillRefusesBadValues) {
  const ScenarioFile file("other: {x: 1}\nrun: {duration_s: 1, macro_step_s: 0}\n");
  EXPECT_THROW((void)load(file.path(), part_of_table(), {}, UnknownKeys::Ignore), Error);
}

TEST(ResolvedScenario, OverridesAreWrittenOut) {
  const Loaded loaded = load_text(kText, table(), {{"output.vtu_every_steps", "4"}});
  EXPECT_NE(loaded.resolved_yaml.find("vtu_every_steps: 4"), std::string::npos);
  EXPECT_EQ(load_text(loaded.resolved_yaml, table()).hash, loaded.hash);
}

TEST(ResolvedScenario, ReadsDifficultTextsBackUnchanged) {
  Section root;
  root.keys = {text("t").must()};
  for (const std::string value : {"", " ", "null", "~", "a\\b", "\"", "'", "#", "- a", "\x01", "µ",
                                  "{a: b}", "line\nline\n"}) {
    std::string quoted = "t: \"";
    for (const char c : value) {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += c == '\n' ? std::string("\\n") : c == '\x01' ? "\\x01" : std::string(1, c);
    }
    const Loaded given = load_text(quoted + "\"", root);
    EXPECT_EQ(given.root.text("t"), value);
    EXPECT_EQ(load_text(given.resolved_yaml, root).root.text("t"), value);
  }
}

TEST(ResolvedScenario, BadDefaultInTheTableIsADefectOfOurs) {
  Section root;
  root.keys = {real("erp", "").between(0, 1).by_default("2")};
  EXPECT_THROW((void)load_text("{}", root), std::logic_error);
}

}  // namespace
}  // namespace tandem::scenario
