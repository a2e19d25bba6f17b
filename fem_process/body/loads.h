#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/body/params.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// The loads of a scenario as nodal forces (N) for a value 1 of their laws.
class LoadCase {
 public:
  LoadCase() = default;
  LoadCase(const TetMesh& mesh, const std::vector<Load>& loads);

  /// Adds all loads at time t to the nodal forces f (N).
  void add(double t_s, Eigen::VectorXd& f) const;

 private:
  struct Entry {
    Eigen::VectorXd unit;  ///< N
    Law law;
  };
  std::vector<Entry> entries_;
};

}  // namespace tandem::fem
