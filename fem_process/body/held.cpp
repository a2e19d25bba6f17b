#include "fem_process/body/held.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

/// For every node the lowest node of its part, to which elements lead from it.
std::vector<int> parts_of(const TetMesh& mesh) {
  std::vector<int> lower(mesh.X.size());
  std::iota(lower.begin(), lower.end(), 0);
  const auto root = [&lower](int node) {
    while (lower[static_cast<std::size_t>(node)] != node) {
      int& next = lower[static_cast<std::size_t>(node)];
      next = lower[static_cast<std::size_t>(next)];
      node = next;
    }
    return node;
  };
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const std::vector<int> nodes = mesh.element(e);
    for (int node : nodes) {
      const int a = root(nodes.front());
      const int b = root(node);
      lower[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
  for (std::size_t node = 0; node < lower.size(); ++node) {
    lower[node] = root(static_cast<int>(node));
  }
  return lower;
}

/// Twice the area (m²) of the largest triangle on the first node and the one farthest from it.
double spread(const TetMesh& mesh, const std::vector<int>& nodes) {
  if (nodes.empty()) return 0.0;
  const auto X = [&](int node) { return mesh.X[static_cast<std::size_t>(node)]; };
  const Eigen::Vector3d a = X(nodes.front());
  const auto nearer = [&](int i, int j) { return (X(i) - a).norm() < (X(j) - a).norm(); };
  const Eigen::Vector3d base = X(*std::max_element(nodes.begin(), nodes.end(), nearer)) - a;
  double largest = 0.0;
  for (int node : nodes) largest = std::max(largest, base.cross(X(node) - a).norm());
  return largest;
}

std::string what_is_loose(const Model& model, const std::vector<int>& part, std::size_t lowest) {
  const auto size = std::count(part.begin(), part.end(), static_cast<int>(lowest));
  if (static_cast<std::size_t>(size) == part.size()) return "the body";
  return "a part of the body (" + std::to_string(size) + " of its " + std::to_string(part.size()) +
         " nodes, among them node " + std::to_string(model.mesh.node_tags[lowest]) + " of " +
         model.mesh.file.string() + ") shares no node with the rest and";
}

}  // namespace

void require_held(const Model& model) {
  const std::vector<int> part = parts_of(model.mesh);
  std::vector<std::vector<int>> held(part.size());
  for (int node : model.prescribed) {
    held[static_cast<std::size_t>(part[static_cast<std::size_t>(node)])].push_back(node);
  }
  const double size = diagonal_of(model.mesh);
  for (std::size_t node = 0; node < part.size(); ++node) {
    if (part[node] != static_cast<int>(node)) continue;
    if (spread(model.mesh, held[node]) > 1e-9 * size * size) continue;
    require(false, "fem: " + what_is_loose(model, part, node) +
                       " is not held against rigid motion, which statics needs: ports and fixed "
                       "sets have " +
                       std::to_string(held[node].size()) +
                       " of its nodes, and it takes three that are not in line. Name a node set "
                       "in fem.fixed or attach a port; or let it move: fem.analysis.kind: "
                       "transient, or an integrator other than quasi_static.");
  }
}

}  // namespace tandem::fem
