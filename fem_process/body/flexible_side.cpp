#include "fem_process/body/flexible_side.h"

namespace tandem::fem {

MeanMotion mean_motion(const Model& model, const State& state, const std::string& node_set) {
  const NodeSet& set = find_set(model.mesh, {.name = node_set});
  MeanMotion mean;
  for (int node : set.nodes) {
    mean.position_m += state.x.segment<3>(3 * node);
    mean.displacement_m +=
        state.x.segment<3>(3 * node) - model.mesh.X[static_cast<std::size_t>(node)];
    mean.velocity_m_per_s += state.v.segment<3>(3 * node);
  }
  const auto n = static_cast<double>(set.nodes.size());
  return {mean.displacement_m / n, mean.position_m / n, mean.velocity_m_per_s / n};
}

MeanMotion FlexibleSide::mean_motion(const std::string& node_set) const {
  return fem::mean_motion(model(), nodal_state(), node_set);
}

}  // namespace tandem::fem
