#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "fem_process/elements/tet4_assembly.h"
#include "fem_process/kernels/polar_lanes.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/material/material.h"
#include "fem_process/matrix/block_matrix.h"
#include "fem_process/matrix/tet4.h"

namespace tandem::fem {

/// Forces and simplified tangent of co-rotational tetrahedra of one isotropic material (λ, μ in
/// Pa), without a 12 × 12 matrix. With ∇N_i the shape gradients (1/m), V the volume (m³) of an
/// element:
///   ε = sym(Rᵀ F) − I,  f_i = V R (λ tr ε I + 2 μ ε) ∇N_i,  R = polar(F),
/// and the stiffness of Tet4Assembly. Eight elements at a time, neighbours together: see
/// near_order(); and polar_lanes() for inverted ones.
class CorotationalKernel {
 public:
  /// `positions` (m) of the pattern's nodes at rest.
  CorotationalKernel(const std::vector<TetShape>& shapes, const BlockPattern& pattern,
                     const Material& material, const std::vector<Eigen::Vector3d>& positions);

  /// Sets f_int (N) and K (N/m) at positions x (m); returns the number of inverted elements.
  int evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K,
               ThreadTeam& team) const;

  using Lane = std::array<double, kLanes>;

  /// Eight elements side by side; the last batch repeats its last element to be full.
  struct Batch {
    std::array<std::array<int, 4>, kLanes> node{};
    std::array<Lane, 9> gradient{};  ///< ∂N_{i+1}/∂X_a at 3 i + a (1/m)
    Lane volume{};                   ///< m³
    Lane root_volume{};              ///< √V
    int count = 0;                   ///< elements that are not repetitions
  };

 private:
  CorotationalKernel(const std::vector<TetShape>& shapes, const BlockPattern& pattern,
                     const Material& material, const std::vector<int>& elements,
                     const std::vector<int>& nodes);

  double lambda_;
  double mu_;
  Tet4Assembly assembly_;
  std::vector<Batch> batches_;
};

}  // namespace tandem::fem
