#include "mbs_process/world_links.h"

#include <fmt/format.h>

#include <map>
#include <string>

#include "mbs_process/params.h"
#include "protocol/scenario/multibody_worlds.h"

namespace tandem::mbs {
namespace {

using scenario::Node;

/// The world of every body, by name.
using Homes = std::map<std::string, std::string>;

void require_at_home(const Node& link, const std::string& end, const std::string& world,
                     const Homes& homes) {
  const std::string body = link.text(end);
  if (body == kWorld && end != "body1") return;
  const auto found = homes.find(body);
  if (found == homes.end()) {
    std::vector<std::string> known;
    for (const auto& [name, home] : homes) {
      if (home == world) known.push_back(name);
    }
    link.fail(end,
              fmt::format("there is no body '{}'.{}", body, scenario::did_you_mean(body, known)));
  }
  if (found->second == world) return;
  link.fail(end, fmt::format("'{}' is a body of world '{}', and this is world '{}': worlds are "
                             "coupled through flexible bodies only. Put what it joins into one "
                             "world, or join it by a flexible body.",
                             body, found->second, world));
}

}  // namespace

void refuse_links(const std::vector<Node>& worlds) {
  Homes homes;
  for (const Node& world : worlds) {
    for (const Node& body : scenario::frames_of(world)) {
      homes.emplace(body.text("name"), world.text("name"));
    }
  }
  const auto require_all = [&](const Node& world, const char* list,
                               const std::vector<std::string>& ends) {
    if (!world.has(list)) return;
    for (const Node& link : world.list(list)) {
      for (const std::string& end : ends) {
        require_at_home(link, end, world.text("name"), homes);
      }
    }
  };
  for (const Node& world : worlds) {
    require_all(world, "joints", {"body1", "body2"});
    require_all(world, "springs", {"body1", "body2"});
    require_all(world, "forces", {"body"});
  }
}

}  // namespace tandem::mbs
