#include "orchestrator/nodal_scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "fem_process/fem_keys.h"
#include "fem_process/nodal_body.h"
#include "mbs_process/mbs_keys.h"
#include "orchestrator/scenario_table.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/common_keys.h"

namespace tandem::orchestrator {
namespace {

scenario::Key bodies_key() {
  const scenario::Key mbs = mbs::mbs_keys();
  scenario::Key bodies =
      *std::ranges::find(mbs.section->keys, std::string("bodies"), &scenario::Key::name);
  bodies.required = false;
  return bodies;
}

/// The part of the table that says whether there is anything to make: all of it may be left out.
const scenario::Section& probe_table() {
  static const scenario::Section table = [] {
    scenario::Section mbs;
    mbs.title = "Multibody side";
    mbs.keys = {bodies_key()};
    scenario::Section root;
    root.title = "Scenario";
    root.keys = scenario::root_keys();
    for (scenario::Key key : {scenario::run_keys(), scenario::section("mbs", std::move(mbs)),
                              fem::fem_keys(), scenario::ports_keys()}) {
      root.keys.push_back(std::move(key));
    }
    for (scenario::Key& key : root.keys) key.required = false;
    return root;
  }();
  return table;
}

/// Bodies and ports only as a whole: their parts are named after what is yet to be made.
bool concerns_probe(const std::string& path) {
  return path.starts_with("fem.") || path.starts_with("run.") || path == "ports" ||
         path == "mbs.bodies";
}

std::optional<scenario::Loaded> probe(const std::filesystem::path& file,
                                      const std::vector<scenario::Override>& overrides) {
  std::vector<scenario::Override> known;
  for (const scenario::Override& override : overrides) {
    if (concerns_probe(override.path)) known.push_back(override);
  }
  try {
    return scenario::load(file, probe_table(), known, scenario::UnknownKeys::Ignore);
  } catch (const Error&) {
    return std::nullopt;  // loading it in full says all that is wrong
  }
}

std::string triple(const Eigen::Vector3d& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

std::vector<scenario::Override> made_of_nodes(const std::filesystem::path& file,
                                              const std::vector<scenario::Override>& overrides) {
  const std::optional<scenario::Loaded> loaded = probe(file, overrides);
  if (!loaded || !loaded->root.has("fem")) return {};
  const scenario::Node& root = loaded->root;
  const scenario::Node fem = root.section("fem");
  if (!fem.has("coupling") || fem.text("coupling") != "nodal") return {};
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
