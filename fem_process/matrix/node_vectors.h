#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/kernels/simd.h"

namespace tandem::fem {

/// The 3-vector that begins at a row of a field.
[[nodiscard]] inline Eigen::Vector3d at(const Eigen::VectorXd& field, Eigen::Index row) {
  return field.segment<3>(row);
}

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

/// The 3-vectors of all nodes, each with a zero behind it.
inline void pad(const Eigen::VectorXd& x, std::vector<Padded>& padded) {
  padded.resize(static_cast<std::size_t>(x.size()) / 3);
  const double* from = x.data();
  for (Padded& node : padded) {
    node = {{from[0], from[1], from[2], 0.0}};
    from += 3;
  }
}

/// The reverse.
inline void unpad(const std::vector<Padded>& padded, Eigen::VectorXd& x) {
  x.resize(3 * static_cast<Eigen::Index>(padded.size()));
  double* to = x.data();
  for (const Padded& node : padded) {
    for (int k = 0; k < 3; ++k) to[k] = node.at[k];
    to += 3;
  }
}

}  // namespace tandem::fem
