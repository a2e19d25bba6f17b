#include "orchestrator/scenario/nodal_scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "fem_process/keys/fem_keys.h"
#include "fem_process/sides/nodal_body.h"
#include "mbs_process/mbs_keys.h"
#include "orchestrator/scenario/scenario_table.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/common_keys.h"

namespace tandem::orchestrator {
namespace {

/// A key of a section, not required.
scenario::Key key_of(const scenario::Key& section, const std::string& name) {
  scenario::Key key = *std::ranges::find(section.section->keys, name, &scenario::Key::name);
  key.required = false;
  return key;
}

scenario::Section section_of(std::string title, std::vector<scenario::Key> keys) {
  scenario::Section section;
  section.title = std::move(title);
  section.keys = std::move(keys);
  for (scenario::Key& key : section.keys) key.required = false;
  return section;
}

/// Whether it is about nodes at all.
bool is_nodal(const std::filesystem::path& file, const std::vector<scenario::Override>& overrides) {
  static const scenario::Section table = [] {
    const scenario::Key coupling =
        scenario::choice("coupling", {"ports", "nodal"}).by_default("ports");
    return section_of("Scenario",
                      {scenario::section("fem", section_of("Flexible body", {coupling}))});
  }();
  std::vector<scenario::Override> known;
  std::ranges::copy_if(overrides, std::back_inserter(known),
                       [](const auto& o) { return o.path == "fem.coupling"; });
  try {
    const scenario::Node root =
        scenario::load(file, table, known, scenario::UnknownKeys::Ignore).root;
    return root.has("fem") && root.section("fem").text("coupling") == "nodal";
  } catch (const Error&) {
    return false;  // loading it in full says all that is wrong
  }
}

/// The part of the table that the nodes follow from; bodies and ports may be left out.
const scenario::Section& nodal_table() {
  static const scenario::Section table = [] {
    const scenario::Key all = mbs::mbs_keys();
    const scenario::Section mbs =
        section_of("Multibody side", {key_of(all, "name"), key_of(all, "bodies")});
    std::vector<scenario::Key> keys = scenario::root_keys();
    for (scenario::Key key : {scenario::run_keys(), scenario::section("mbs", mbs).or_several(),
                              fem::fem_keys(), scenario::ports_keys()}) {
      keys.push_back(std::move(key));
    }
    return section_of("Scenario", std::move(keys));
  }();
  return table;
}

/// Bodies and ports only as a whole: their parts are named after what is yet to be made.
bool concerns_nodes(const scenario::Override& override) {
  const std::string& path = override.path;
  return path.starts_with("fem.") || path.starts_with("run.") || path == "ports" ||
         path == "mbs.bodies";
}

std::string triple(const Eigen::Vector3d& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

std::vector<scenario::Override> made_of_nodes(const std::filesystem::path& file,
                                              const std::vector<scenario::Override>& overrides) {
  if (!is_nodal(file, overrides)) return {};
  std::vector<scenario::Override> known;
  std::ranges::copy_if(overrides, std::back_inserter(known), concerns_nodes);
  const scenario::Node root =
      scenario::load(file, nodal_table(), known, scenario::UnknownKeys::Ignore).root;
  if (root.has("mbs") && root.holds_list("mbs")) {
    root.fail("mbs",
              "is a list of worlds, and with fem.coupling: nodal the nodes are bodies of one. Give "
              "it a mapping, without '- ' and name.");
  }
  const bool bodies_listed = root.has("mbs") && root.section("mbs").has("bodies");
  if (root.has("ports") && bodies_listed) return {};  // a resolved scenario
  if (root.has("ports")) {
    root.fail("ports",
              "with fem.coupling: nodal the ports are made from the mesh. Leave them out.");
  }
  if (bodies_listed) {
    root.section("mbs").fail("bodies",
                             "with fem.coupling: nodal the bodies are made from the mesh. Leave "
                             "them out; joints and springs may name them node_<tag>.");
  }
  require_mesh_file(root);
  std::string bodies;
  std::string ports;
  for (const fem::NodeMass& node : fem::node_masses(fem::read_params(root))) {
    const char* comma = bodies.empty() ? "" : ", ";
    // Nothing ever turns a node: any moment of inertia will do.
    const Eigen::Vector3d inertia = Eigen::Vector3d::Constant(node.mass_kg);
    fmt::format_to(std::back_inserter(bodies),
                   "{}{{name: {}, mass_kg: {}, inertia_kg_m2: {}, position_m: {}, "
                   "velocity_m_per_s: {}}}",
                   comma, node.name, node.mass_kg, triple(inertia), triple(node.position_m),
                   triple(node.velocity_m_per_s));
    fmt::format_to(std::back_inserter(ports), "{}{{name: {}, body: {}, node_set: {}}}", comma,
                   node.name, node.name, node.name);
  }
  return {{"mbs.bodies", "[" + bodies + "]"}, {"ports", "[" + ports + "]"}};
}

}  // namespace

std::vector<scenario::Override> with_nodes(const std::filesystem::path& file,
                                           std::vector<scenario::Override> overrides) {
  std::vector<scenario::Override> all = made_of_nodes(file, overrides);
  std::ranges::move(overrides, std::back_inserter(all));
  return all;
}

}  // namespace tandem::orchestrator
