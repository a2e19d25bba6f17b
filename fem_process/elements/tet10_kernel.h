#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "fem_process/elements/solid_element.h"
#include "fem_process/elements/tet10_assembly.h"
#include "fem_process/kernels/polar_lanes.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/material/material.h"
#include "fem_process/matrix/block_matrix.h"

namespace tandem::fem {

/// Forces and simplified tangent of co-rotational tetrahedra of ten nodes and one isotropic
/// material (λ, μ in Pa), without a 30 × 30 matrix. At each of the four integration points, of
/// volume V (m³) and shape gradients ∇N_i (1/m),
///   ε = sym(Rᵀ F) − I,  f_i = Σ V R (λ tr ε I + 2 μ ε) ∇N_i,  R = polar(F),
/// and the stiffness of Tet10Assembly. Eight elements at a time, in the order of the mesh; see
/// polar_lanes() for inverted ones.
class Tet10Kernel {
 public:
  Tet10Kernel(const std::vector<SolidElement<10>>& elements, const BlockPattern& pattern,
              const Material& material);

  /// Sets f_int (N) and K (N/m) at positions x (m); returns the number of elements that are
  /// inverted at a point.
  int evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K,
               ThreadTeam& team) const;

  /// Exact directional derivatives (N) of f_int(x) + K(x) y along the columns of dx, y held. With
  /// Z = Rᵀ Σ (x_i + y_i) ∂N_iᵀ, A = Rᵀ dF and the rotation's own derivative R [ω],
  /// (tr U I − U) ω = axial A, U = Rᵀ F (ω = 0 where a lane is inverted),
  ///   df_i = Σ V R ([ω] C : (Z − I) + C : (A − [ω] Z)) ∇N_i.
  [[nodiscard]] Eigen::MatrixXd derivatives(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                                            const Eigen::MatrixXd& dx, ThreadTeam& team) const;

  /// Strain energy (J), ½ Σ V σ : ε.
  [[nodiscard]] double energy(const Eigen::VectorXd& x, ThreadTeam& team) const;

  using Lane = std::array<double, kLanes>;

  struct Point {
    std::array<Lane, 27> gradient{};  ///< ∂N_{i+1}/∂X_a at 3 i + a (1/m)
    Lane volume{};                    ///< m³
    Lane root_volume{};               ///< √V
  };
  /// Eight elements side by side; the last batch repeats its last element to be full.
  struct Batch {
    std::array<std::array<int, 10>, kLanes> node{};
    std::array<Point, 4> points{};
    int count = 0;  ///< elements that are not repetitions
  };

 private:
  double lambda_;
  double mu_;
  Tet10Assembly assembly_;
  std::vector<Batch> batches_;
};

}  // namespace tandem::fem
