#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// The second-order tetrahedron in its barycentric coordinates L_0 … L_3: corners first, then the
/// nodes on the edges in the order of kTetEdges.
///   N_i = L_i (2 L_i − 1),  N_ab = 4 L_a L_b

/// Place of the edge between two corners in kTetEdges.
[[nodiscard]] std::size_t edge_between(std::size_t a, std::size_t b);

/// The ten shape functions.
[[nodiscard]] Eigen::Matrix<double, 10, 1> tet10_shape(const Eigen::Vector4d& L);

/// ∂N_i/∂L_k at fixed other coordinates, L_0 = 1 − L_1 − L_2 − L_3: columns k = 1, 2, 3.
[[nodiscard]] Eigen::Matrix<double, 10, 3> tet10_derivatives(const Eigen::Vector4d& L);

/// A point of a rule for integrals over a tet: ∫ f dV = V Σ weight f(L); the weights sum to 1.
struct TetPoint {
  Eigen::Vector4d L;
  double weight = 0.0;
};
/// Exact for polynomials of degree 2: the stiffness of a straight second-order tet.
[[nodiscard]] const std::array<TetPoint, 4>& tet_rule_of_degree_2();
/// Exact for polynomials of degree 5, 14 points [Walkington 2000]: the mass of a straight
/// second-order tet has degree 4.
[[nodiscard]] const std::vector<TetPoint>& tet_rule_of_degree_5();

/// Reference positions of an element's ten nodes as rows (m).
[[nodiscard]] Eigen::Matrix<double, 10, 3> tet10_positions(const TetMesh& mesh,
                                                           std::size_t element);

/// Volume (m³) of an element of either order, curved edges included.
[[nodiscard]] double volume(const TetMesh& mesh, std::size_t element);

/// Smallest Jacobians of an element of ten nodes (rows), relative to that of the straight tet on
/// its corners: 1 when the mid nodes are in the middle of straight edges.
struct SmallestJacobian {
  double at_points = 1.0;  ///< of the rule of degree 2
  double at_nodes = 1.0;
};
[[nodiscard]] SmallestJacobian smallest_jacobian(const Eigen::Matrix<double, 10, 3>& X);

}  // namespace tandem::fem
