#include "protocol/scenario/common_keys.h"

#include "protocol/scenario/law.h"
#include "tests/unit/scenario/support.h"

namespace tandem::scenario {
namespace {

Section table() {
  Section root;
  root.title = "Scenario";
  root.keys = root_keys();
  root.keys.push_back(run_keys());
  root.keys.push_back(ports_keys());
  root.keys.push_back(output_keys());
  return root;
}

const char* const kGood = R"(name: lug
description: "Lug: on a crank"
run: {duration_s: 0.5, macro_step_s: 1e-3}
ports:
  - {name: base, body: crank, node_set: BASE}
  - {name: eye, body: payload, node_set: EYE, position_m: [1, 2, 3],
     orientation_wxyz: [0.6, 0, 0.8, 0]}
output: {vtu_every_steps: 10}
)";

/// kGood with one piece of text replaced.
std::string with(const std::string& old_text, const std::string& new_text) {
  std::string text = kGood;
  const auto at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return text.replace(at, old_text.size(), new_text);
}

// A ramp, a table and a change, in sections and lists; not those at 0, at the end and behind it.
TEST(CommonKeys, EventsAreTheCornersOfLawsAndTheTimesOfChanges) {
  Section root = table();
  Section load, change;
  load.title = "Load";
  load.keys = {law("law", "N")};
  change.title = "Change";
  change.keys = {real("at_s", "s")};
  root.keys.push_back(sections("loads", std::move(load)));
  root.keys.push_back(section("change", std::move(change)));
  const std::string text = std::string(kGood) + R"(loads:
  - {law: {kind: ramp, end_s: 0.3, value_end: 1}}
  - {law: {kind: table, times_s: [0, 0.1, 0.3, 0.5, 0.7], values: [0, 1, 0, 1, 0]}}
  - {law: 3}
change: {at_s: 0.2000000005}
)";
  const std::vector<SimTime> events = read_run(load_text(text, root).root).events;
  EXPECT_EQ(events, (std::vector<SimTime>{SimTime(100'000'000), SimTime(200'000'000),
                                          SimTime(300'000'000)}));
}

TEST(CommonKeys, AreReadAsWritten) {
  const Loaded loaded = load_text(kGood, table());
  EXPECT_EQ(loaded.root.text("name"), "lug");
  EXPECT_EQ(loaded.root.text("description"), "Lug: on a crank");
  const RunParams run = read_run(loaded.root);
  EXPECT_EQ(run.duration, SimTime(500'000'000));
  EXPECT_EQ(run.macro_step, SimTime(1'000'000));
  EXPECT_EQ(run.macro_steps(), 500);
  const auto ports = read_ports(loaded.root);
  ASSERT_EQ(ports.size(), 2U);
  EXPECT_EQ(ports[0].name, "base");
  EXPECT_EQ(ports[0].body, "crank");
  EXPECT_EQ(ports[0].node_set, "BASE");
  EXPECT_TRUE(ports[0].at_body_frame);
  EXPECT_EQ(ports[0].q_WP.coeffs(), Eigen::Quaterniond::Identity().coeffs());
  EXPECT_FALSE(ports[1].at_body_frame);
  EXPECT_EQ(ports[1].p_WP, Eigen::Vector3d(1, 2, 3));
  // 0.6² + 0.8² = 1 to one rounding, so normalising moves the last bit at most.
  EXPECT_NEAR(ports[1].q_WP.w(), 0.6, 2e-16);
  EXPECT_NEAR(ports[1].q_WP.y(), 0.8, 2e-16);
  EXPECT_EQ(ports[1].place.line, 6);
  EXPECT_EQ(ports[1].place.column, 5);
  const OutputParams output = read_output(loaded.root);
  EXPECT_EQ(output.vtu_every_steps, 10);
  EXPECT_EQ(output.bodies_every_steps, 1);
}

struct BadValue {
  const char* old_text;
  const char* new_text;
  const char* defect;
};

TEST(CommonKeys, OneBadValuePerKeyIsRefusedAtItsPlace) {
  const std::vector<BadValue> cases = {
      {"name: lug", "name: 2nd lug",
       "scenario.yaml:1:7: name: '2nd lug' is not a name. Begin with a letter, then use letters, "
       "digits and '_' only."},
      {"\"Lug: on a crank\"", "[a]",
       "scenario.yaml:2:14: description: is a list. It must be text."},
      {"0.5,", "-0.5,",
       "scenario.yaml:3:19: run.duration_s: -0.5 is out of range. It must be > 0 s."},
      {"1e-3", "0", "scenario.yaml:3:38: run.macro_step_s: 0 is out of range. It must be > 0 s."},
      {"1e-3", "1e-3, pace: fast",
       "scenario.yaml:3:50: run.pace: 'fast' is no pace. Write free, real_time, or simulated "
       "seconds per second of wall time, e.g. 0.5 (1e-06 to 1e+06)."},
      {"1e-3", "1e-3, pace: -1",
       "scenario.yaml:3:50: run.pace: '-1' is no pace. Write free, real_time, or simulated "
       "seconds per second of wall time, e.g. 0.5 (1e-06 to 1e+06)."},
      {"base", "ba-se",
       "scenario.yaml:5:12: ports.0.name: 'ba-se' is not a name. Begin with a letter, then use "
       "letters, digits and '_' only."},
      {"crank,", "\"\",",
       "scenario.yaml:5:24: ports.base.body: '' is not a name. Begin with a letter, then use "
       "letters, digits and '_' only."},
      {"BASE", "{}",
       "scenario.yaml:5:41: ports.base.node_set: is a mapping of keys to values. It must be text."},
      {"[1, 2, 3]", "[1, 2]",
       "scenario.yaml:6:59: ports.eye.position_m: has 2 entries. It must be a list of exactly 3 "
       "numbers."},
      {"0.6, ", "0.7, ",
       "scenario.yaml:7:24: ports.eye.orientation_wxyz: has the norm 1.06301. It must be 1: divide "
       "each number by 1.06301."},
      {"vtu_every_steps: 10", "vtu_every_steps: 2.5",
       "scenario.yaml:8:27: output.vtu_every_steps: '2.5' is not a whole number. Write a whole "
       "number like 10."},
      {"vtu_every_steps: 10", "bodies_every_steps: -1",
       "scenario.yaml:8:30: output.bodies_every_steps: -1 is out of range. It must be ≥ 0."},
      {"vtu_every_steps: 10", "bodies_every_steps: often",
       "scenario.yaml:8:30: output.bodies_every_steps: 'often' is not a whole number. Write a "
       "whole number like 10."},
  };
  for (const BadValue& bad : cases) {
    expect_defect(with(bad.old_text, bad.new_text), table(), bad.defect);
  }
}

TEST(CommonKeys, DurationIsAWholeNumberOfMacroSteps) {
  expect_defect(with("0.5,", "0.0105,"), table(),
                "scenario.yaml:3:19: run.duration_s: 0.0105 s is not a whole number of macro steps "
                "of 0.001 s. Use 0.01 s or 0.011 s.");
  expect_defect(with("0.5,", "0.0005,"), table(),
                "scenario.yaml:3:19: run.duration_s: 0.0005 s is not a whole number of macro steps "
                "of 0.001 s. Use 0.001 s.");
}

TEST(CommonKeys, TimesAreWholeNanoseconds) {
  const auto defects = defects_of(with("1e-3", "1.5e-9"), table());
  ASSERT_EQ(defects.size(), 1U);
  EXPECT_TRUE(defects[0].starts_with("scenario.yaml:3:38: run.macro_step_s: ")) << defects[0];
  EXPECT_NE(defects[0].find("not a whole number of nanoseconds"), std::string::npos) << defects[0];
}

TEST(CommonKeys, AtLeastOnePortIsNeeded) {
  expect_defect("name: a\nrun: {duration_s: 1, macro_step_s: 1}\nports: []\n", table(),
                "scenario.yaml:3:8: ports: has 0 entries. It must be a list of at least 1 "
                "mapping.");
}

TEST(CommonKeys, PortNamesDiffer) {
  expect_defect(with("eye", "base"), table(),
                "scenario.yaml:6:12: ports.1.name: 'base' is already the name of another entry at "
                "scenario.yaml:5:12. Names must differ.");
}

}  // namespace
}  // namespace tandem::scenario
