#include "protocol/scenario/side_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>

#include "protocol/scenario/data.h"

namespace tandem::scenario {
namespace {

constexpr std::size_t kLongestName = 64;
constexpr const char* kTaken[] = {"mbs", "fem", "orchestrator", "tool", "logs"};

}  // namespace

std::vector<std::string> names_of(const std::vector<Node>& nodes) {
  std::vector<std::string> names;
  for (const Node& node : nodes) names.push_back(node.text("name"));
  return names;
}

Node view_of(const Node& root, std::string_view key, const Node& own,
             const std::vector<std::size_t>& ports) {
  Data data = root.data();
  data.values.find(key)->second.content = std::make_shared<const Data>(own.data());
  if (const auto found = data.values.find("ports"); found != data.values.end()) {
    const auto all = std::get<std::vector<DataPtr>>(found->second.content);
    std::vector<DataPtr> kept;
    for (const std::size_t i : ports) kept.push_back(all[i]);
    found->second.content = std::move(kept);
  }
  return Node(std::make_shared<const Data>(std::move(data)));
}

void require_side_name(const Node& side) {
  const std::string name = side.text("name");
  if (name.size() > kLongestName) {
    side.fail("name", fmt::format("has {} letters. A body's name has {} at most.", name.size(),
                                  kLongestName));
  }
  if (std::find(std::begin(kTaken), std::end(kTaken), name) == std::end(kTaken)) return;
  side.fail("name",
            fmt::format("'{}' is the name of a process of every run. Choose another.", name));
}

}  // namespace tandem::scenario
