#include "protocol/scenario/flexible_bodies.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "protocol/scenario/side_view.h"

namespace tandem::scenario {
namespace {

/// The number of the body that a port belongs to.
std::size_t owner_of(const Node& port, const std::vector<std::string>& names) {
  if (!port.has("flexible") && names.size() == 1) return 0;
  if (!port.has("flexible")) {
    port.fail("flexible", fmt::format("is missing. fem lists several bodies: name the port's, one "
                                      "of {}.",
                                      fmt::join(names, ", ")));
  }
  const std::string name = port.text("flexible");
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    port.fail("flexible",
              fmt::format("'{}' is no body of fem.{}", name, did_you_mean(name, names)));
  }
  return static_cast<std::size_t>(found - names.begin());
}

BodyPorts only_body(const Node& root) {
  BodyPorts body;
  const Node fem = root.section("fem");
  if (fem.has("name")) body.name = fem.text("name");
  if (!root.has("ports")) return body;
  const std::vector<Node> ports = root.list("ports");
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (ports[i].has("flexible") && ports[i].text("flexible") != body.name) {
      ports[i].fail("flexible", fmt::format("'{}' is not fem.name: there is one flexible body. "
                                            "Leave it out, or make fem a list of named bodies.",
                                            ports[i].text("flexible")));
    }
    body.ports.push_back(i);
  }
  return body;
}

}  // namespace

std::vector<BodyPorts> body_table(const Node& root) {
  if (!root.holds_list("fem")) return {only_body(root)};
  const std::vector<Node> nodes = root.list("fem");
  const std::vector<std::string> names = names_of(nodes);
  std::vector<BodyPorts> bodies(nodes.size());
  const std::vector<Node> table = root.has("ports") ? root.list("ports") : std::vector<Node>{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    bodies[owner_of(table[i], names)].ports.push_back(i);
  }
  for (std::size_t b = 0; b < nodes.size(); ++b) {
    require_side_name(nodes[b]);
    bodies[b].name = names[b];
    if (!bodies[b].ports.empty()) continue;
    nodes[b].fail("name", fmt::format("no port belongs to '{0}'. Say flexible: {0} at its ports, "
                                      "or remove the body.",
                                      names[b]));
  }
  return bodies;
}

std::vector<FlexibleBody> flexible_bodies(const Node& root) {
  std::vector<FlexibleBody> bodies;
  const std::vector<BodyPorts> table = body_table(root);
  if (!root.holds_list("fem")) return {{table.front().name, root, table.front().ports}};
  const std::vector<Node> nodes = root.list("fem");
  for (std::size_t b = 0; b < nodes.size(); ++b) {
    bodies.push_back(
        {table[b].name, view_of(root, "fem", nodes[b], table[b].ports), table[b].ports});
  }
  return bodies;
}

Key flexible_names_key() {
  Section fem;
  fem.title = "Flexible body";
  fem.keys = {name("name").doc_is("Its name, where there are several.")};
  return section("fem", std::move(fem)).or_several();
}

}  // namespace tandem::scenario
