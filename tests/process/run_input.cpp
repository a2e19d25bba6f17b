#include <gtest/gtest.h>

#include <functional>
#include <regex>

#include "tests/support/tandem_process.h"

// Broken scenarios and meshes: exit code 2, the place, what is wrong and what would
// be right, in `tandem check` and in `tandem run` alike.
namespace tandem::test {
namespace {

const std::string kJoint = "  joints:\n    - {name: bearing, kind: hinge, ";

/// Puts `now` in place of the first `before`; a text that is not there would make a test empty.
std::string replaced(std::string text, const std::string& before, const std::string& now) {
  const std::size_t at = text.find(before);
  if (at == std::string::npos) throw std::logic_error("nothing to break: " + before);
  return text.replace(at, before.size(), now);
}

struct Fault {
  std::string name;
  std::string place;               ///< regular expression behind the folder: file:line:column
  std::vector<std::string> words;  ///< essential words of what is wrong and what would be right
  std::function<std::string(const std::string&)> scenario = [](const std::string& s) { return s; };
  std::function<std::string(const std::string&)> mesh = [](const std::string& m) { return m; };
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }
std::string name_of(const testing::TestParamInfo<Fault>& test) { return test.param.name; }

/// A fault of the scenario's text.
Fault in_scenario(const std::string& name, const std::string& before, const std::string& now,
                  const std::string& place, std::vector<std::string> words) {
  Fault fault{name, "scenario.yaml:" + place, std::move(words)};
  fault.scenario = [before, now](const std::string& s) { return replaced(s, before, now); };
  return fault;
}
Fault in_mesh(const std::string& name, const std::string& place, std::vector<std::string> words,
              std::function<std::string(const std::string&)> damage) {
  Fault fault{name, place, std::move(words)};
  fault.mesh = std::move(damage);
  return fault;
}

/// The first tetrahedron's line of the mesh: behind the header "3 <entity> 4 <count>".
std::string with_first_tet(const std::string& mesh,
                           const std::function<std::string(std::smatch)>& f) {
  std::smatch found;
  const std::regex header("\n3 [0-9]+ 4 [0-9]+\n([0-9]+) ([0-9]+) ([0-9]+) ([0-9]+) ([0-9]+)");
  if (!std::regex_search(mesh, found, header)) throw std::logic_error("no tetrahedra");
  const auto at = static_cast<std::size_t>(found.position(1));
  const std::size_t end = mesh.find('\n', at);
  return mesh.substr(0, at) + f(found) + mesh.substr(end);
}

std::vector<Fault> scenario_faults() {
  return {
      in_scenario("unknown_key", "run:\n", "run:\n  colour: red\n", R"(\d+:3: )",
                  {"run.colour: is not a key here", "duration_s", "macro_step_s"}),
      in_scenario("misspelt_key", "duration_s:", "duraton_s:", R"(\d+:3: )",
                  {"Did you mean 'duration_s' (s)?"}),
      in_scenario("misspelt_section", "\nrun:", "\nrunn:", R"(\d+:1: )", {"Did you mean 'run'?"}),
      in_scenario("duplicate_key", "  macro_step_s: 0.001\n",
                  "  macro_step_s: 0.001\n  macro_step_s: 0.002\n", R"(\d+:3: )",
                  {"is given twice", "Remove one of the two"}),
      in_scenario("tab", "  macro_step_s", "\tmacro_step_s", R"(\d+:1: )",
                  {"tab", "Indent with spaces"}),
      in_scenario("wrong_unit_in_key", "macro_step_s: 0.001", "macro_step_ms: 1", R"(\d+:3: )",
                  {"macro_step_ms: is not a key here", "'macro_step_s' (s)"}),
      in_scenario("value_with_unit", "macro_step_s: 0.001", "macro_step_s: 1 ms", R"(\d+:17: )",
                  {"'1 ms' carries a unit", "plain numbers", "in s"}),
      in_scenario("text_for_a_number", "macro_step_s: 0.001", "macro_step_s: fast", R"(\d+:17: )",
                  {"'fast' is not a number", "0.001"}),
      in_scenario("not_a_number", "density_kg_per_m3: 1000", "density_kg_per_m3: .nan",
                  R"(\d+:\d+: )", {"density_kg_per_m3", "finite number"}),
      in_scenario("negative_mass", "mass_kg: 2.0", "mass_kg: -2.0", R"(\d+:16: )",
                  {"mbs.bodies.left.mass_kg", "out of range", "> 0 kg"}),
      in_scenario("zero_step", "macro_step_s: 0.001", "macro_step_s: 0", R"(\d+:17: )",
                  {"macro_step_s", "> 0 s"}),
      in_scenario("inertia_not_positive", "[0.004, 0.008, 0.008]", "[-0.004, 0.008, 0.008]",
                  R"(\d+:22: )", {"inertia_kg_m2", "positive definite", "Ixx"}),
      in_scenario("inertia_of_no_body", "[0.004, 0.008, 0.008]", "[0.004, 0.008, 0.1]",
                  R"(\d+:22: )", {"triangle inequality"}),
      in_scenario("inertia_of_two_numbers", "[0.004, 0.008, 0.008]", "[0.004, 0.008]",
                  R"(\d+:22: )", {"inertia_kg_m2", "3"}),
      in_scenario("unknown_body_in_joint",
                  "\nfem:", kJoint + "body1: lefft, anchor_m: [0, 0, 0], axis: [0, 0, 1]}\n\nfem:",
                  R"(\d+:\d+: )", {"lefft", "Did you mean 'left'?"}),
      in_scenario("zero_axis",
                  "\nfem:", kJoint + "body1: left, anchor_m: [0, 0, 0], axis: [0, 0, 0]}\n\nfem:",
                  R"(\d+:\d+: )", {"axis that is not zero", "[0, 0, 1]"}),
      in_scenario("joint_without_anchor",
                  "\nfem:", kJoint + "body1: left, axis: [0, 0, 1]}\n\nfem:", R"(\d+:\d+: )",
                  {"anchor_m: is missing", "3 numbers in m"}),
      in_scenario("port_without_node_set", "node_set: right", "node_set: rigth", R"(\d+:\d+: )",
                  {"no node set 'rigth'", "Did you mean 'right'?"}),
      in_scenario("port_without_body", "body: right,", "body: rigth,", R"(\d+:\d+: )",
                  {"no body 'rigth'", "Did you mean 'right'?"}),
      in_scenario("node_in_two_ports", "node_set: right", "node_set: left", R"(\d+:\d+: )",
                  {"belongs to the ports 'left' and 'right'", "choose sets without common nodes"}),
      in_scenario("two_ports_of_one_name", "name: right, body", "name: left, body", R"(\d+:\d+: )",
                  {"left"}),
      in_scenario("list_for_a_mapping", "mesh: {file: bar.msh}", "mesh: [bar.msh]", R"(\d+:9: )",
                  {"fem.mesh: is a list", "mapping of keys to values"}),
      in_scenario("mapping_for_a_number", "macro_step_s: 0.001", "macro_step_s: {s: 1}",
                  R"(\d+:17: )", {"macro_step_s", "must be a number"}),
      in_scenario("step_does_not_divide", "macro_step_s: 0.001", "macro_step_s: 0.0003",
                  R"(\d+:\d+: )", {"not a whole number of macro steps", "0.9999 s or 1.0002 s"}),
      in_scenario("unknown_choice", "scheme: interface_jacobian", "scheme: implizit", R"(\d+:11: )",
                  {"'implizit' is not known",
                   "explicit_serial, explicit_parallel, implicit, interface_jacobian, tlm"}),
      in_scenario("missing_section", "\nports:\n", "\n# ports\n", R"(\d+:\d+: )", {}),
      in_scenario("poisson_of_no_material", "poisson: 0.3", "poisson: 0.5", R"(\d+:\d+: )",
                  {"fem.material.poisson", "< 0.5"}),
  };
}

Fault empty_scenario() {
  Fault fault{"empty_file", R"(scenario.yaml:1:1: )", {"the file is empty", "mapping of keys"}};
  fault.scenario = [](const std::string&) { return std::string(); };
  return fault;
}

std::vector<Fault> mesh_faults() {
  Fault missing{"mesh_missing", R"((bar|baar)\.msh)", {"cannot be read", "fem.mesh.file"}};
  missing.scenario = [](const std::string& s) { return replaced(s, "bar.msh", "baar.msh"); };
  return {
      missing,
      in_mesh("binary_head_on_text", R"(bar.msh:3: )", {"byte order", "write it again"},
              [](const std::string& m) { return replaced(m, "4.1 0 8", "4.1 1 8"); }),
      in_mesh("mesh_of_version_3", R"(bar.msh:2: )",
              {"version 3", "2 to 4.1 are", "gmsh bar.msh -save -format msh41 -o bar_41.msh"},
              [](const std::string& m) { return replaced(m, "4.1 0 8", "3 0 8"); }),
      in_mesh("truncated_mesh", R"(bar.msh:\d+: )", {"truncated", "write it again"},
              [](const std::string& m) { return m.substr(0, m.size() / 2); }),
      in_mesh("mesh_cut_in_its_head", R"(bar.msh:\d+: )", {"truncated"},
              [](const std::string& m) { return m.substr(0, 60); }),
      in_mesh("inverted_tetrahedron", R"(bar.msh:\d+: )", {"negative volume", "mesh again"},
              [](const std::string& m) {
                return with_first_tet(m, [](const std::smatch& t) {
                  return t.str(1) + " " + t.str(3) + " " + t.str(2) + " " + t.str(4) + " " +
                         t.str(5);
                });
              }),
      in_mesh("flat_tetrahedron", R"(bar.msh:\d+: )", {"no volume", "mesh again"},
              [](const std::string& m) {
                return with_first_tet(m, [](const std::smatch& t) {
                  return t.str(1) + " " + t.str(2) + " " + t.str(2) + " " + t.str(4) + " " +
                         t.str(5);
                });
              }),
      in_mesh("tetrahedron_with_unknown_node", R"(bar.msh:\d+: )",
              {"uses node 99999, which the file does not define"},
              [](const std::string& m) {
                return with_first_tet(m, [](const std::smatch& t) {
                  return t.str(1) + " 99999 " + t.str(3) + " " + t.str(4) + " " + t.str(5);
                });
              }),
      in_mesh("empty_mesh", R"(bar.msh:1: )", {"ends where $MeshFormat should be"},
              [](const std::string&) { return std::string(); }),
      in_mesh("no_mesh_at_all", R"(bar.msh:1: )", {"not a Gmsh mesh", "$MeshFormat"},
              [](const std::string&) { return std::string("solid cube\n"); }),
  };
}

class BrokenInput : public testing::TestWithParam<Fault> {};

TEST_P(BrokenInput, IsRefusedWithItsPlaceAndTheRemedy) {
  const TemporaryFolder folder("tandem_input");
  const std::string example = kExamples + "two_masses/";
  const std::string scenario = (folder / "scenario.yaml").string();
  write_file(scenario, GetParam().scenario(read_file(example + "scenario.yaml")));
  write_file(folder / "bar.msh", GetParam().mesh(read_file(example + "bar.msh")));
  const std::string out = (folder / "run").string();
  for (const auto& command : std::vector<std::vector<std::string>>{
           {"check", scenario},
           {"run", scenario, "--quiet", "--out", out + "_lcm"},
           {"run", scenario, "--quiet", "--transport", "inproc", "--out", out + "_inproc"}}) {
    const Ended ended = tandem_command(command);
    EXPECT_EQ(ended.code, 2) << command[0] << ": " << ended.output;
    const std::regex place(folder.path().string() + "/" + GetParam().place);
    EXPECT_TRUE(std::regex_search(ended.output, place)) << command[0] << ": " << ended.output;
    for (const std::string& words : GetParam().words) {
      EXPECT_NE(ended.output.find(words), std::string::npos)
          << command[0] << " does not say '" << words << "': " << ended.output;
    }
  }
  EXPECT_TRUE(processes_with(folder.path().string()).empty());
}

INSTANTIATE_TEST_SUITE_P(Scenario, BrokenInput, testing::ValuesIn(scenario_faults()), name_of);
INSTANTIATE_TEST_SUITE_P(Empty, BrokenInput, testing::Values(empty_scenario()), name_of);
INSTANTIATE_TEST_SUITE_P(Mesh, BrokenInput, testing::ValuesIn(mesh_faults()), name_of);

// All defects of a file are told at once: nobody fixes them one by one.
TEST(Check, ShowsSizeAndMassThatRevealAWrongUnit) {
  // The bar of 0.5 × 0.05 × 0.05 m and 1000 kg/m³.
  const Ended ended = tandem_command({"check", kExamples + "two_masses/scenario.yaml"});
  EXPECT_EQ(ended.code, 0) << ended.output;
  for (const char* words :
       {"0.5 × 0.05 × 0.05 m", "0.00125 m³, 1.25 kg", "port 'left': 13 nodes"}) {
    EXPECT_NE(ended.output.find(words), std::string::npos) << words << " in: " << ended.output;
  }
}

// The bar's end face is the square of ±0.025 m at x = −0.25 m, the body's frame at x = −0.28 m: its
// corners are √(0.03² + 2 × 0.025²) m away. A body that is moved along shows by as much.
TEST(Check, MeasuresAPortFromWhereItsBodyStands) {
  struct Place {
    std::string x, distance;
  };
  for (const Place& place : {Place{"-0.28", "up to 0.0464 m"}, Place{"-1.25", "up to 1 m"}}) {
    std::vector<std::string> check = {"check", kExamples + "two_masses/scenario.yaml", "--set"};
    check.push_back("mbs.bodies.left.position_m=[" + place.x + ", 0, 0]");
    const Ended ended = tandem_command(check);
    EXPECT_EQ(ended.code, 0) << ended.output;
    EXPECT_NE(ended.output.find(place.distance + " from its origin (" + place.x + ", 0, 0) m"),
              std::string::npos)
        << ended.output;
  }
}

// 1e8 N/m on 2 kg at 1 ms: h² k/m = 50, as explicit springs cannot follow. The coupling's monitor
// stops the run first; the note says whose fault it is.
TEST(Check, WarnsOfASpringThatTheStepCannotFollow) {
  const TemporaryFolder folder("tandem_spring");
  const std::string spring =
      "mbs.springs=[{name: stay, body1: left, point1_m: [-0.28, 0, 0], point2_m: [-1, 0, 0], "
      "stiffness_N_per_m: 1e8}]";
  std::vector<std::string> check = {"check", kExamples + "two_masses/scenario.yaml", "--set"};
  check.push_back(spring);
  const Ended checked = tandem_command(check);
  EXPECT_EQ(checked.code, 0) << checked.output;
  EXPECT_NE(checked.output.find("warning: spring 'stay' is too stiff"), std::string::npos)
      << checked.output;
  EXPECT_NE(checked.output.find("Set mbs.micro_step_s below 0.00028"), std::string::npos)
      << checked.output;
  check.insert(check.end(), {"--set", "mbs.micro_step_s=0.0002"});
  const Ended finer = tandem_command(check);
  EXPECT_EQ(finer.code, 0) << finer.output;
  EXPECT_EQ(finer.output.find("warning: spring"), std::string::npos) << finer.output;

  std::vector<std::string> more = {"--transport", "inproc", "--set"};
  more.push_back(spring);
  const Ended run = run_command(run_of("two_masses", folder / "run", more));
  EXPECT_EQ(run.code, 3) << run.output;
  EXPECT_NE(run.output.find("spring 'stay' is too stiff"), std::string::npos) << run.output;
}

// ½ r w² h²/erp of the crank of 0.1 m at three turns per second, with steps of 1 ms: 8.88e-4 of it.
TEST(Check, WarnsOfAPinThatTheStepLeavesOffItsCircle) {
  const std::vector<std::string> check = {"check", kExamples + "slider_crank/scenario.yaml"};
  const Ended fine = tandem_command(check);
  EXPECT_EQ(fine.code, 0) << fine.output;
  EXPECT_EQ(fine.output.find("warning: joint"), std::string::npos) << fine.output;
  std::vector<std::string> coarse = check;
  coarse.insert(coarse.end(), {"--set", "run.macro_step_s=0.001"});
  const Ended warned = tandem_command(coarse);
  EXPECT_EQ(warned.code, 0) << warned.output;
  EXPECT_NE(warned.output.find(
                "warning: joint 'crank_pin' will be off by about 8.88e-05 m: at 18.85 rad/s"),
            std::string::npos)
      << warned.output;
}

TEST(Check, TakesAScenarioForTheFlexibleSideAlone) {
  const Ended ended = tandem_command({"check", kExamples + "hinge/scenario.yaml"});
  EXPECT_EQ(ended.code, 0) << ended.output;
  EXPECT_NE(ended.output.find("good, for `tandem fem`"), std::string::npos) << ended.output;
}

TEST(BrokenInputs, AllDefectsOfAFileAreTold) {
  const TemporaryFolder folder("tandem_input");
  std::string text = read_file(kExamples + "two_masses/scenario.yaml");
  text = replaced(text, "duration_s:", "duraton_s:");
  text = replaced(text, "mass_kg: 2.0", "mass_kg: -2.0");
  text = replaced(text, "poisson: 0.3", "poisson: 1 m");
  write_file(folder / "scenario.yaml", text);
  const Ended ended = tandem_command({"check", (folder / "scenario.yaml").string()});
  EXPECT_EQ(ended.code, 2);
  for (const char* words : {"duraton_s", "-2.0 is out of range", "'1 m' carries a unit"}) {
    EXPECT_NE(ended.output.find(words), std::string::npos) << words << ": " << ended.output;
  }
}

}  // namespace
}  // namespace tandem::test
