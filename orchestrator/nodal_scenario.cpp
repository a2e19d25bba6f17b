#include "orchestrator/nodal_scenario.h"

#include <fmt/format.h>

#include <iterator>
#include <optional>
#include <string>

#include "fem_process/fem_keys.h"
#include "fem_process/nodal_body.h"
#include "mbs_process/mbs_keys.h"
#include "orchestrator/scenario_table.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/common_keys.h"

namespace tandem::orchestrator {
namespace {

/// The part of the table that says whether there is anything to make: all of it may be left out.
scenario::Section probe_table() {
  scenario::Section table;
  table.title = "Scenario";
  scenario::Key bodies;
  for (const scenario::Key& key : mbs::mbs_keys().section->keys) {
    if (key.name == "bodies") bodies = key;
  }
  bodies.required = false;
  scenario::Section mbs;
  mbs.title = "Multibody side";
  mbs.keys = {std::move(bodies)};
  table.keys = scenario::root_keys();
  table.keys.push_back(scenario::section("mbs", std::move(mbs)));
  table.keys.push_back(fem::fem_keys());
  table.keys.push_back(scenario::ports_keys());
  for (scenario::Key& key : table.keys) key.required = false;
  return table;
}

std::optional<scenario::Loaded> probe(const std::filesystem::path& file,
                                      const std::vector<scenario::Override>& overrides) {
  std::vector<scenario::Override> known;
  for (const scenario::Override& override : overrides) {
    if (override.path.starts_with("fem.")) known.push_back(override);
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

}  // namespace

std::vector<scenario::Override> nodal_overrides(const std::filesystem::path& file,
                                                const std::vector<scenario::Override>& overrides) {
  const std::optional<scenario::Loaded> loaded = probe(file, overrides);
  if (!loaded || !loaded->root.has("fem")) return {};
  const scenario::Node& root = loaded->root;
  const scenario::Node fem = root.section("fem");
  if (!fem.has("coupling") || fem.text("coupling") != "nodal" || root.has("ports")) return {};
  if (root.has("mbs") && root.section("mbs").has("bodies")) {
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

}  // namespace tandem::orchestrator
