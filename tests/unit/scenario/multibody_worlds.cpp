// One multibody world or a list of named ones: whose ports are whose, and what is said when that
// cannot be told.
#include "protocol/scenario/multibody_worlds.h"

#include "protocol/scenario/common_keys.h"
#include "tests/unit/scenario/support.h"

namespace tandem::scenario {
namespace {

/// A scenario's ports, flexible names and a multibody side with one key of its own.
const Section& worlds_table() {
  static const Section table = [] {
    Section body;
    body.title = "Body";
    body.keys = {name("name").must()};
    Section mbs;
    mbs.title = "Multibody side";
    mbs.keys = {name("name"), real("erp", "").by_default("0.2"), sections("bodies", body).must(),
                sections("junctions", body)};
    Section root;
    root.title = "Scenario";
    root.keys = {ports_keys(), section("mbs", std::move(mbs)).must().or_several(),
                 flexible_names_key()};
    root.check = [](const Node& node) { (void)multibody_worlds(node); };
    return root;
  }();
  return table;
}

std::string ports_on(const std::vector<std::string>& bodies) {
  std::string text = "ports:\n";
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    text += "  - {name: p" + std::to_string(i) + ", body: " + bodies[i] + "}\n";
  }
  return text;
}

const std::string kWorlds =
    "mbs:\n"
    "  - {name: near, erp: 0.1, bodies: [{name: a}, {name: b}]}\n"
    "  - {name: far, erp: 0.4, bodies: [{name: c}]}\n"
    "fem: {}\n";

TEST(MultibodyWorlds, OneMappingHasAllPorts) {
  const Loaded loaded =
      load_text(ports_on({"a", "a"}) + "mbs: {bodies: [{name: a}]}\nfem: {}\n", worlds_table());
  const std::vector<MultibodyWorld> worlds = multibody_worlds(loaded.root);
  ASSERT_EQ(worlds.size(), 1U);
  EXPECT_EQ(worlds[0].name, "");
  EXPECT_EQ(worlds[0].ports, (std::vector<std::size_t>{0, 1}));
}

TEST(MultibodyWorlds, APortBelongsToTheWorldOfItsBody) {
  const Loaded loaded = load_text(ports_on({"c", "b", "c", "a"}) + kWorlds, worlds_table());
  const std::vector<MultibodyWorld> worlds = multibody_worlds(loaded.root);
  ASSERT_EQ(worlds.size(), 2U);
  EXPECT_EQ(worlds[0].name, "near");
  EXPECT_EQ(worlds[0].ports, (std::vector<std::size_t>{1, 3}));
  EXPECT_EQ(worlds[1].ports, (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(worlds[1].root.section("mbs").real("erp"), 0.4);
  EXPECT_EQ(worlds[1].root.section("mbs").path_name("erp"), "mbs.far.erp");
  const std::vector<PortParams> ports = read_ports(worlds[0].root);
  ASSERT_EQ(ports.size(), 2U);
  EXPECT_EQ(ports[1].name, "p3");
}

// A flexible body sees the worlds that it has ports on, each with all of its ports.
TEST(MultibodyWorlds, AreSeenByAFlexibleBody) {
  const std::string text =
      "ports:\n"
      "  - {name: p0, body: c, flexible: rod}\n"
      "  - {name: p1, body: a, flexible: arm}\n"
      "  - {name: p2, body: c, flexible: arm}\n"
      "mbs:\n"
      "  - {name: near, bodies: [{name: a}]}\n"
      "  - {name: far, bodies: [{name: c}]}\n"
      "fem: [{name: rod}, {name: arm}]\n";
  const Loaded loaded = load_text(text, worlds_table());
  const std::vector<FlexibleBody> bodies = flexible_bodies(loaded.root);
  const std::vector<MultibodyWorld> of_rod = worlds_at(bodies[0].root);
  ASSERT_EQ(of_rod.size(), 1U);
  EXPECT_EQ(of_rod[0].name, "far");
  const std::vector<MultibodyWorld> of_arm = worlds_at(bodies[1].root);
  ASSERT_EQ(of_arm.size(), 2U);
  EXPECT_EQ(of_arm[1].ports, std::vector<std::size_t>{1});
  EXPECT_EQ(read_ports(of_arm[1].root).size(), 2U);
  EXPECT_EQ(of_arm[1].root.section("mbs").text("name"), "far");
}

// A resolved scenario gives the same worlds, and --set finds them by name.
TEST(MultibodyWorlds, AreSetByNameAndResolved) {
  const std::string text = ports_on({"a", "c"}) + kWorlds;
  const Loaded loaded = load_text(text, worlds_table(), {parse_override("mbs.far.erp=0.7")});
  EXPECT_EQ(multibody_worlds(loaded.root)[1].root.section("mbs").real("erp"), 0.7);
  const Loaded again = load_text(loaded.resolved_yaml, worlds_table());
  EXPECT_EQ(again.hash, loaded.hash);
  EXPECT_EQ(multibody_worlds(again.root)[1].root.section("mbs").real("erp"), 0.7);
}

TEST(MultibodyWorlds, DefectsNameThePlace) {
  const Section& table = worlds_table();
  expect_defect(ports_on({"a", "d"}) + kWorlds, table,
                "scenario.yaml:3:22: ports.p1.body: 'd' is no body of any world of mbs.");
  expect_defect(ports_on({"a"}) + kWorlds, table,
                "scenario.yaml:5:12: mbs.far.name: no port is on a body of 'far', and worlds are "
                "coupled through flexible bodies only. Give it a port, or remove the world.");
  expect_defect(ports_on({"a"}) +
                    "mbs:\n  - {name: u, bodies: [{name: a}]}\n"
                    "  - {name: v, bodies: [{name: a}]}\nfem: {}\n",
                table,
                "scenario.yaml:5:31: mbs.v.bodies.a.name: 'a' is a body of world 'u' as well. The "
                "names of bodies differ over all worlds, since ports name them.");
  expect_defect(ports_on({"a"}) + "mbs:\n  - {name: fem, bodies: [{name: a}]}\nfem: {}\n", table,
                "scenario.yaml:4:12: mbs.fem.name: 'fem' is the name of a process of every run. "
                "Choose another.");
  expect_defect(
      ports_on({"a"}) + "mbs:\n  - {name: rod, bodies: [{name: a}]}\nfem: [{name: rod}]\n", table,
      "scenario.yaml:4:12: mbs.rod.name: 'rod' is the name of a flexible body, too. "
      "Choose another.");
  expect_defect(ports_on({"a"}) + "mbs:\n  - {bodies: [{name: a}]}\nfem: {}\n", table,
                "scenario.yaml:4:5: mbs.0: has no name. Each of several needs one: name: …");
}

TEST(MultibodyWorlds, AFlexibleSideReadsTheirNamesAndBodiesAlone) {
  Section root;
  root.title = "Scenario";
  root.keys = {ports_keys(), multibody_names_key(), flexible_names_key()};
  const Loaded loaded = load_text(ports_on({"c", "b"}) + kWorlds, root, {}, UnknownKeys::Ignore);
  const std::vector<BodyPorts> worlds = world_table(loaded.root);
  ASSERT_EQ(worlds.size(), 2U);
  EXPECT_EQ(worlds[1].name, "far");
  EXPECT_EQ(worlds[1].ports, std::vector<std::size_t>{0});
}

}  // namespace
}  // namespace tandem::scenario
