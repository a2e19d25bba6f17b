#include "protocol/scenario/multibody_worlds.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "protocol/scenario/side_view.h"

namespace tandem::scenario {
namespace {

/// Which world each rigid body is in; no two have the same name.
std::map<std::string, std::size_t> homes_of(const std::vector<Node>& worlds) {
  std::map<std::string, std::size_t> homes;
  for (std::size_t w = 0; w < worlds.size(); ++w) {
    for (const Node& body : frames_of(worlds[w])) {
      const auto [known, is_new] = homes.emplace(body.text("name"), w);
      if (is_new) continue;
      body.fail("name", fmt::format("'{}' is a body of world '{}' as well. The names of bodies "
                                    "differ over all worlds, since ports name them.",
                                    known->first, worlds[known->second].text("name")));
    }
  }
  return homes;
}

std::size_t home_of(const Node& port, const std::map<std::string, std::size_t>& homes) {
  const std::string body = port.text("body");
  const auto found = homes.find(body);
  if (found != homes.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [name, world] : homes) known.push_back(name);
  port.fail("body",
            fmt::format("'{}' is no body of any world of mbs.{}", body, did_you_mean(body, known)));
}

std::vector<std::string> flexible_names(const Node& root) {
  if (!root.has("fem")) return {};
  if (root.holds_list("fem")) return names_of(root.list("fem"));
  const Node fem = root.section("fem");
  return fem.has("name") ? names_of({fem}) : std::vector<std::string>{};
}

/// Processes, logs and folders of both kinds of sides lie side by side.
void refuse_shared_name(const Node& root, const Node& world) {
  const std::vector<std::string> bodies = flexible_names(root);
  const std::string name = world.text("name");
  if (std::find(bodies.begin(), bodies.end(), name) == bodies.end()) return;
  world.fail("name",
             fmt::format("'{}' is the name of a flexible body, too. Choose another.", name));
}

bool has_several(const Node& root) { return root.has("mbs") && root.holds_list("mbs"); }

std::vector<std::size_t> all_ports(const Node& root) {
  std::vector<std::size_t> ports(root.has("ports") ? root.list("ports").size() : 0);
  std::iota(ports.begin(), ports.end(), std::size_t{0});
  return ports;
}

BodyPorts only_world(const Node& root) {
  BodyPorts world{.name = {}, .ports = all_ports(root)};
  if (root.has("mbs") && root.section("mbs").has("name")) {
    world.name = root.section("mbs").text("name");
    refuse_shared_name(root, root.section("mbs"));
  }
  return world;
}

std::vector<BodyPorts> rows_of(const Node& root) {
  if (!has_several(root)) return {only_world(root)};
  const std::vector<Node> nodes = root.list("mbs");
  const std::map<std::string, std::size_t> homes = homes_of(nodes);
  std::vector<BodyPorts> worlds;
  for (const std::string& name : names_of(nodes)) worlds.push_back({.name = name, .ports = {}});
  if (!root.has("ports")) return worlds;
  const std::vector<Node> ports = root.list("ports");
  for (std::size_t i = 0; i < ports.size(); ++i) {
    worlds[home_of(ports[i], homes)].ports.push_back(i);
  }
  return worlds;
}

}  // namespace

std::vector<Node> frames_of(const Node& mbs) {
  std::vector<Node> frames;
  for (const char* list : {"bodies", "junctions"}) {
    if (!mbs.has(list)) continue;
    for (const Node& frame : mbs.list(list)) frames.push_back(frame);
  }
  return frames;
}

std::vector<BodyPorts> world_table(const Node& root) {
  std::vector<BodyPorts> rows = rows_of(root);
  if (!has_several(root)) return rows;
  const std::vector<Node> nodes = root.list("mbs");
  for (std::size_t w = 0; w < rows.size(); ++w) {
    require_side_name(nodes[w]);
    refuse_shared_name(root, nodes[w]);
    if (!rows[w].ports.empty()) continue;
    nodes[w].fail("name", fmt::format("no port is on a body of '{}', and worlds are coupled "
                                      "through flexible bodies only. Give it a port, or remove "
                                      "the world.",
                                      rows[w].name));
  }
  return rows;
}

std::vector<MultibodyWorld> multibody_worlds(const Node& root) {
  const std::vector<BodyPorts> rows = world_table(root);
  if (!has_several(root)) return {{rows.front().name, root, rows.front().ports}};
  const std::vector<Node> nodes = root.list("mbs");
  std::vector<MultibodyWorld> worlds;
  for (std::size_t w = 0; w < rows.size(); ++w) {
    worlds.push_back({rows[w].name, view_of(root, "mbs", nodes[w], rows[w].ports), rows[w].ports});
  }
  return worlds;
}

std::vector<MultibodyWorld> worlds_at(const Node& root) {
  const std::vector<BodyPorts> rows = rows_of(root);
  if (!has_several(root)) return {{rows.front().name, root, rows.front().ports}};
  const std::vector<std::size_t> all = all_ports(root);
  const std::vector<Node> nodes = root.list("mbs");
  std::vector<MultibodyWorld> worlds;
  for (std::size_t w = 0; w < rows.size(); ++w) {
    if (rows[w].ports.empty()) continue;
    worlds.push_back({rows[w].name, view_of(root, "mbs", nodes[w], all), rows[w].ports});
  }
  return worlds;
}

Key multibody_names_key() {
  Section body;
  body.title = "Rigid body";
  body.keys = {name("name").doc_is("Its name.")};
  Section mbs;
  mbs.title = "Multibody side";
  mbs.keys = {name("name").doc_is("Its name, where there are several."), sections("bodies", body),
              sections("junctions", std::move(body))};
  return section("mbs", std::move(mbs)).or_several();
}

}  // namespace tandem::scenario
