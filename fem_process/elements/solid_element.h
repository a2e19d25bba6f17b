#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "fem_process/matrix/block_matrix.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// Geometry of one tetrahedron of N nodes, the same for all formulations: N = 4 with one
/// integration point, exact since its strain is uniform, or N = 10 with four (exact for the
/// stiffness of a straight element; rank 24 = 30 − 6: no modes without strain energy but the
/// rigid ones).
template <int N>
struct SolidElement {
  static_assert(N == 4 || N == 10);
  static constexpr std::size_t kPoints = N == 4 ? 1 : 4;
  /// Forces and stiffness are formed for nodes 1 … N − 1: node 0 takes minus their sum, since
  /// nothing changes with a common translation.
  static constexpr int kInner = 3 * (N - 1);

  struct Point {
    Eigen::Matrix<double, N, 3> gradients;  ///< ∂N_i/∂X (1/m)
    double volume = 0.0;                    ///< weight times Jacobian (m³)
  };
  std::array<int, N> nodes{};
  std::array<Point, kPoints> points;
  std::array<int, N * N> blocks{};  ///< position of block (i, j) at N i + j

  /// Positions or displacements of nodes 1 … N − 1 less those of node 0, as columns (m). Taking
  /// differences keeps round-off independent of the distance from the world origin.
  using Differences = Eigen::Matrix<double, 3, N - 1>;
  [[nodiscard]] Differences differences(const Eigen::VectorXd& x) const;

  /// Σ x_i ∂N_i/∂X at a point.
  [[nodiscard]] static Eigen::Matrix3d gradient_of(const Differences& d, const Point& point) {
    return d * point.gradients.template bottomRows<N - 1>();
  }

  /// Adds the forces V P ∂N_i/∂X of a first Piola–Kirchhoff stress P at a point.
  void add_forces(const Point& point, const Eigen::Matrix3d& P, Eigen::VectorXd& f) const;

  /// Derivative of P by F: column a + 3 b holds DP[e_a e_bᵀ], by columns.
  using Tangent = Eigen::Matrix<double, 9, 9>;
  using Stiffness = Eigen::Matrix<double, kInner, kInner>;
  /// Adds V ∂N_i/∂X_d ∂N_j/∂X_b A_(cd)(ab) for i ≤ j; the rest of K stays.
  static void add_stiffness(const Point& point, const Tangent& A, Stiffness& K);
  /// Adds the stiffness of all nodes, exactly symmetric, into the blocks of a pattern.
  void add_to_pattern(const Stiffness& upper, BlockValues& K) const;
};

/// Elements of a mesh of the fitting order.
template <int N>
[[nodiscard]] std::vector<SolidElement<N>> make_elements(const TetMesh& mesh,
                                                         const BlockPattern& pattern);

extern template struct SolidElement<4>;
extern template struct SolidElement<10>;

}  // namespace tandem::fem
