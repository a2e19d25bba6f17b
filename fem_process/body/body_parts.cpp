#include "fem_process/body/body_parts.h"

#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace tandem::fem {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

/// Shortest ways (m) along the pattern's connections from a set of nodes to all others [Dijkstra].
std::vector<double> ways_from(const Model& model, const std::vector<int>& sources) {
  const BlockPattern& pattern = model.pattern();
  std::vector<double> way(model.mesh.X.size(), kFar);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> next;
  for (int node : sources) {
    way[static_cast<std::size_t>(node)] = 0.0;
    next.emplace(0.0, node);
  }
  while (!next.empty()) {
    const auto [reached, node] = next.top();
    next.pop();
    const auto at = static_cast<std::size_t>(node);
    if (reached > way[at]) continue;
    for (int b = pattern.row_start[at]; b < pattern.row_start[at + 1]; ++b) {
      const int other = pattern.column[static_cast<std::size_t>(b)];
      const auto to = static_cast<std::size_t>(other);
      const double longer = reached + (model.mesh.X[to] - model.mesh.X[at]).norm();
      if (longer >= way[to]) continue;
      way[to] = longer;
      next.emplace(longer, other);
    }
  }
  return way;
}

std::vector<BodyPart> connected_nodes(const BlockPattern& pattern) {
  std::vector<BodyPart> parts;
  std::vector<int> part_of(static_cast<std::size_t>(pattern.rows()), -1);
  std::vector<int> stack;
  for (int first = 0; first < pattern.rows(); ++first) {
    if (part_of[static_cast<std::size_t>(first)] >= 0) continue;
    const auto number = static_cast<int>(parts.size());
    parts.emplace_back();
    part_of[static_cast<std::size_t>(first)] = number;
    stack.push_back(first);
    while (!stack.empty()) {
      const auto at = static_cast<std::size_t>(stack.back());
      stack.pop_back();
      for (int b = pattern.row_start[at]; b < pattern.row_start[at + 1]; ++b) {
        const int other = pattern.column[static_cast<std::size_t>(b)];
        int& part = part_of[static_cast<std::size_t>(other)];
        if (part >= 0) continue;
        part = number;
        stack.push_back(other);
      }
    }
  }
  for (int node = 0; node < pattern.rows(); ++node) {
    parts[static_cast<std::size_t>(part_of[static_cast<std::size_t>(node)])].nodes.push_back(node);
  }
  return parts;
}

/// Row of φ from the ways to all holders of a part.
Eigen::RowVectorXd shares_of(const std::vector<std::vector<double>>& ways, int node) {
  Eigen::RowVectorXd share(static_cast<Eigen::Index>(ways.size()));
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const double way = ways[k][static_cast<std::size_t>(node)];
    if (way == 0.0) return Eigen::RowVectorXd::Unit(share.size(), static_cast<Eigen::Index>(k));
    share(static_cast<Eigen::Index>(k)) = 1.0 / way;
  }
  return share / share.sum();
}

}  // namespace

std::vector<BodyPart> body_parts(const Model& model) {
  std::vector<BodyPart> parts = connected_nodes(model.pattern());
  std::vector<std::vector<std::vector<double>>> ways(parts.size());
  const auto hold = [&](int holder, const std::vector<int>& nodes) {
    if (nodes.empty()) return;
    const std::vector<double> way = ways_from(model, nodes);
    for (std::size_t s = 0; s < parts.size(); ++s) {
      if (way[static_cast<std::size_t>(parts[s].nodes.front())] == kFar) continue;
      parts[s].holders.push_back(holder);
      ways[s].push_back(way);
    }
  };
  hold(BodyPart::kGround, model.fixed);
  for (std::size_t p = 0; p < model.ports.size(); ++p) {
    hold(static_cast<int>(p), model.ports[p].nodes);
  }
  for (std::size_t s = 0; s < parts.size(); ++s) {
    BodyPart& part = parts[s];
    part.shares.resize(static_cast<Eigen::Index>(part.nodes.size()),
                       static_cast<Eigen::Index>(part.holders.size()));
    if (part.holders.empty()) continue;
    for (std::size_t i = 0; i < part.nodes.size(); ++i) {
      part.shares.row(static_cast<Eigen::Index>(i)) = shares_of(ways[s], part.nodes[i]);
    }
  }
  return parts;
}

}  // namespace tandem::fem
