#include "orchestrator/warnings/set_warnings.h"

#include <fmt/format.h>

#include <set>
#include <string>

namespace tandem::orchestrator {
namespace {

/// Mid nodes of the edges both ends of which are in the set; none if the set has one of its own.
std::set<int> missing_mids(const fem::TetMesh& mesh, const std::vector<bool>& in_set) {
  std::set<int> missing;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    for (std::size_t k = 0; k < 6; ++k) {
      const int mid = mesh.mids[e][k];
      if (in_set[static_cast<std::size_t>(mid)]) return {};
      const int a = mesh.tets[e][fem::kTetEdges[k][0]];
      const int b = mesh.tets[e][fem::kTetEdges[k][1]];
      if (in_set[static_cast<std::size_t>(a)] && in_set[static_cast<std::size_t>(b)]) {
        missing.insert(mid);
      }
    }
  }
  return missing;
}

}  // namespace

std::vector<Finding> corner_nodes_only(const fem::Model& model) {
  const fem::TetMesh& mesh = model.mesh;
  std::vector<Finding> findings;
  if (!mesh.second_order()) return findings;
  std::set<std::string> seen;
  const auto examine = [&](const fem::SetName& name) {
    const auto found = mesh.sets.find(name.name);
    if (found == mesh.sets.end() || !seen.insert(name.name).second) return;
    std::vector<bool> in_set(mesh.X.size(), false);
    for (int node : found->second.nodes) in_set[static_cast<std::size_t>(node)] = true;
    const std::size_t missing = missing_mids(mesh, in_set).size();
    if (missing == 0) return;
    findings.push_back(
        {.name = "corner_nodes_only",
         .text = fmt::format(
             "{}set '{}' ({}) has {} corner nodes of second-order elements and none of the {} mid "
             "nodes on the edges between them, which stay free: the body is softer there. Name a "
             "*SURFACE or a physical group in its place, or list all nodes.",
             name.where(), name.name, found->second.where, found->second.nodes.size(), missing)});
  };
  for (const fem::SetName& name : model.params.fixed) examine(name);
  for (const fem::PortSet& port : model.params.ports) examine(port.set);
  for (const fem::Load& load : model.params.loads) {
    if (load.kind == fem::Load::Kind::Nodal) examine(load.set);
  }
  return findings;
}

}  // namespace tandem::orchestrator
