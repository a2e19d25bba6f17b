#pragma once

#include <Eigen/Core>
#include <vector>

namespace tandem::fem {

/// The 3-vectors of some nodes out of a vector over all nodes, in the order of `nodes`.
[[nodiscard]] inline Eigen::VectorXd gather(const Eigen::VectorXd& whole,
                                            const std::vector<int>& nodes) {
  Eigen::VectorXd part(3 * static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    part.segment<3>(3 * static_cast<Eigen::Index>(k)) = whole.segment<3>(3 * nodes[k]);
  }
  return part;
}

/// The reverse: adds the part to the nodes' entries of the whole.
template <class Part>
void scatter_add(const Part& part, const std::vector<int>& nodes, Eigen::VectorXd& whole) {
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    whole.segment<3>(3 * nodes[k]) += part.template segment<3>(3 * static_cast<Eigen::Index>(k));
  }
}

}  // namespace tandem::fem
