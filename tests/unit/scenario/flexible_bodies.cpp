// One flexible body or a list of named ones: who owns which port, and what is said when that is not
// told.
#include "protocol/scenario/flexible_bodies.h"

#include "protocol/scenario/common_keys.h"
#include "tests/unit/scenario/support.h"

namespace tandem::scenario {
namespace {

/// A scenario's ports and a flexible side with one key of its own.
const Section& bodies_table() {
  static const Section table = [] {
    Section fem;
    fem.title = "Flexible body";
    fem.keys = {name("name"), real("young_Pa", "Pa").must().above(0)};
    Section root;
    root.title = "Scenario";
    root.keys = {ports_keys(), section("fem", std::move(fem)).must().or_several()};
    root.check = [](const Node& node) { (void)flexible_bodies(node); };
    return root;
  }();
  return table;
}

const std::string kBodies =
    "fem:\n"
    "  - {name: rod, young_Pa: 1}\n"
    "  - {name: arm, young_Pa: 2}\n";

std::string ports_of(const std::vector<std::string>& owners) {
  std::string text = "ports:\n";
  for (std::size_t i = 0; i < owners.size(); ++i) {
    text += "  - {name: p" + std::to_string(i) + ", body: b" +
            (owners[i].empty() ? "" : ", flexible: " + owners[i]) + "}\n";
  }
  return text;
}

TEST(FlexibleBodies, OneMappingHasAllPorts) {
  const Loaded loaded = load_text(ports_of({"", ""}) + "fem: {young_Pa: 3}\n", bodies_table());
  const std::vector<FlexibleBody> bodies = flexible_bodies(loaded.root);
  ASSERT_EQ(bodies.size(), 1U);
  EXPECT_EQ(bodies[0].name, "");
  EXPECT_EQ(bodies[0].ports, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(bodies[0].root.section("fem").real("young_Pa"), 3.0);
}

TEST(FlexibleBodies, PortsOfAListOfOneNeedNotNameIt) {
  const Loaded loaded =
      load_text(ports_of({"", "arm"}) + "fem: [{name: arm, young_Pa: 3}]\n", bodies_table());
  const std::vector<FlexibleBody> bodies = flexible_bodies(loaded.root);
  ASSERT_EQ(bodies.size(), 1U);
  EXPECT_EQ(bodies[0].ports, (std::vector<std::size_t>{0, 1}));
}

TEST(FlexibleBodies, EachOfAListReadsItsOwnPartOfTheScenario) {
  const Loaded loaded = load_text(ports_of({"arm", "rod", "arm"}) + kBodies, bodies_table());
  const std::vector<FlexibleBody> bodies = flexible_bodies(loaded.root);
  ASSERT_EQ(bodies.size(), 2U);
  EXPECT_EQ(bodies[0].name, "rod");
  EXPECT_EQ(bodies[0].ports, std::vector<std::size_t>{1});
  EXPECT_EQ(bodies[1].ports, (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(bodies[1].root.section("fem").real("young_Pa"), 2.0);
  EXPECT_EQ(bodies[1].root.section("fem").path_name("young_Pa"), "fem.arm.young_Pa");
  const std::vector<PortParams> ports = read_ports(bodies[1].root);
  ASSERT_EQ(ports.size(), 2U);
  EXPECT_EQ(ports[1].name, "p2");
}

// A resolved scenario gives the same bodies, and --set finds them by name.
TEST(FlexibleBodies, AreSetByNameAndResolved) {
  const std::string text = ports_of({"arm", "rod"}) + kBodies;
  const Loaded loaded = load_text(text, bodies_table(), {parse_override("fem.arm.young_Pa=7")});
  EXPECT_EQ(flexible_bodies(loaded.root)[1].root.section("fem").real("young_Pa"), 7.0);
  const Loaded again = load_text(loaded.resolved_yaml, bodies_table());
  EXPECT_EQ(again.hash, loaded.hash);
  EXPECT_EQ(flexible_bodies(again.root)[1].root.section("fem").real("young_Pa"), 7.0);
}

TEST(FlexibleBodies, DefectsNameThePlace) {
  const Section& table = bodies_table();
  expect_defect(ports_of({"arm", ""}) + kBodies, table,
                "scenario.yaml:3:5: ports.p1.flexible: is missing. fem lists several bodies: name "
                "the port's, one of rod, arm.");
  expect_defect(ports_of({"arm", "rot"}) + kBodies, table,
                "scenario.yaml:3:35: ports.p1.flexible: 'rot' is no body of fem. Did you mean "
                "'rod'?");
  expect_defect(ports_of({"arm"}) + kBodies, table,
                "scenario.yaml:4:12: fem.rod.name: no port belongs to 'rod'. Say flexible: rod at "
                "its ports, or remove the body.");
  expect_defect(ports_of({"arm"}) + "fem: {young_Pa: 1}\n", table,
                "scenario.yaml:2:35: ports.p0.flexible: 'arm' is not fem.name: there is one "
                "flexible body. Leave it out, or make fem a list of named bodies.");
  expect_defect(ports_of({"mbs"}) + "fem:\n  - {name: mbs, young_Pa: 1}\n", table,
                "scenario.yaml:4:12: fem.mbs.name: 'mbs' is the name of a process of every run. "
                "Choose another.");
  expect_defect(ports_of({""}) + "fem:\n  - {young_Pa: 1}\n", table,
                "scenario.yaml:4:5: fem.0: has no name. Each of several needs one: name: …");
}

TEST(FlexibleBodies, ASideThatIsNotFlexibleReadsTheirNamesAlone) {
  Section root;
  root.title = "Scenario";
  root.keys = {ports_keys(), flexible_names_key()};
  const Loaded loaded =
      load_text(ports_of({"arm", "rod"}) + kBodies, root, {}, UnknownKeys::Ignore);
  const std::vector<BodyPorts> bodies = body_table(loaded.root);
  ASSERT_EQ(bodies.size(), 2U);
  EXPECT_EQ(bodies[1].name, "arm");
  EXPECT_EQ(bodies[1].ports, std::vector<std::size_t>{0});
}

}  // namespace
}  // namespace tandem::scenario
