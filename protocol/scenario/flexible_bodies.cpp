#include "protocol/scenario/flexible_bodies.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "protocol/scenario/data.h"

namespace tandem::scenario {
namespace {

constexpr std::size_t kLongestName = 64;
constexpr const char* kTaken[] = {"mbs", "fem", "orchestrator", "tool", "logs"};

std::vector<std::string> names_of(const std::vector<Node>& nodes) {
  std::vector<std::string> names;
  for (const Node& node : nodes) names.push_back(node.text("name"));
  return names;
}

/// The number of the body that a port belongs to.
std::size_t owner_of(const Node& port, const std::vector<std::string>& names) {
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

/// The root with another `fem` and some of the ports.
Node view(const Node& root, DataPtr fem, const std::vector<std::size_t>& ports) {
  Data data = root.data();
  data.values.at("fem").content = std::move(fem);
  if (const auto found = data.values.find("ports"); found != data.values.end()) {
    const auto all = std::get<std::vector<DataPtr>>(found->second.content);
    std::vector<DataPtr> own;
    for (const std::size_t i : ports) own.push_back(all[i]);
    found->second.content = std::move(own);
  }
  return Node(std::make_shared<const Data>(std::move(data)));
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

/// Folders, logs and processes carry the name.
void require_good_name(const Node& body) {
  const std::string name = body.text("name");
  if (name.size() > kLongestName) {
    body.fail("name", fmt::format("has {} letters. A body's name has {} at most.", name.size(),
                                  kLongestName));
  }
  if (std::find(std::begin(kTaken), std::end(kTaken), name) == std::end(kTaken)) return;
  body.fail("name",
            fmt::format("'{}' is the name of a process of every run. Choose another.", name));
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
    require_good_name(nodes[b]);
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
    const auto fem = std::make_shared<const Data>(nodes[b].data());
    bodies.push_back({table[b].name, view(root, fem, table[b].ports), table[b].ports});
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
