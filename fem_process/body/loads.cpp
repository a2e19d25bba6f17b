#include "fem_process/body/loads.h"

#include <numeric>

#include "fem_process/mesh/surface.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

Eigen::VectorXd unit_forces(const TetMesh& mesh, const Load& load) {
  const NodeSet& set = find_set(mesh, load.set);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * mesh.nodes());
  if (load.kind == Load::Kind::Nodal) {
    const Eigen::Vector3d share = load.value / static_cast<double>(set.nodes.size());
    for (int node : set.nodes) f.segment<3>(3 * node) += share;
    return f;
  }
  require(!set.triangles.empty(),
          (load.set.place.file.empty() ? "fem" : load.set.place.text()) + ": set '" +
              load.set.name + "' has no triangles to put a traction on. Name a surface group " +
              "(dimension 2) or a *SURFACE, or make it a nodal load.");
  const std::vector<double> areas = nodal_areas(mesh, set);
  const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
  const Eigen::Vector3d traction =
      load.kind == Load::Kind::Surface ? load.value : Eigen::Vector3d(load.value / total);
  for (int node = 0; node < mesh.nodes(); ++node) {
    f.segment<3>(3 * node) += areas[static_cast<std::size_t>(node)] * traction;
  }
  return f;
}

}  // namespace

LoadCase::LoadCase(const TetMesh& mesh, const std::vector<Load>& loads) {
  for (const Load& load : loads) entries_.push_back({unit_forces(mesh, load), load.law});
}

void LoadCase::add(double t_s, Eigen::VectorXd& f) const {
  for (const Entry& entry : entries_) f += entry.law(t_s) * entry.unit;
}

}  // namespace tandem::fem
