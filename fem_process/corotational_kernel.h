#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "fem_process/block_matrix.h"
#include "fem_process/material.h"
#include "fem_process/polar_lanes.h"
#include "fem_process/tet4.h"

namespace tandem::fem {

/// Forces and simplified tangent of co-rotational tetrahedra of one isotropic material (λ, μ in
/// Pa), without a 12 × 12 matrix. With ∇N_i the shape gradients (1/m), V the volume (m³) of an
/// element:
///   ε = sym(Rᵀ F) − I,  f_i = V R (λ tr ε I + 2 μ ε) ∇N_i,  R = polar(F),
///   K_ij = λ D_ij + μ D_ijᵀ + μ tr D_ij I,  D_ij = Σ c_i c_jᵀ,  c_i = √V R ∇N_i,
/// so that D_ij is summed over the tets of an edge first, and Σ_j D_ij = 0 gives the diagonal.
/// Four elements at a time, in the order of the mesh; see polar_lanes() for inverted ones.
class CorotationalKernel {
 public:
  CorotationalKernel(const std::vector<TetShape>& shapes, const BlockPattern& pattern,
                     const Material& material);

  /// Sets f_int (N) and K (N/m) at positions x (m); returns the number of inverted elements.
  int evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K) const;

  using Lane = std::array<double, kLanes>;

  /// Four elements side by side; the last batch repeats its last element to be full.
  struct Batch {
    std::array<std::array<int, kLanes>, 4> node{};
    std::array<Lane, 9> gradient{};  ///< ∂N_{i+1}/∂X_a at 3 i + a (1/m)
    Lane volume{};                   ///< m³
    Lane root_volume{};              ///< √V
    int count = 0;                   ///< elements that are not repetitions
  };

 private:
  /// D of block (i, j), i < j: products of these vectors c.
  struct Edge {
    int upper = 0;  ///< block (i, j)
    int lower = 0;  ///< block (j, i)
    int i = 0;
    int j = 0;
    int first_term = 0;
  };
  struct Term {
    int c_i = 0;  ///< position of c_i in the elements' vectors
    int c_j = 0;
  };
  void list_edges(const std::vector<TetShape>& shapes, const BlockPattern& pattern);
  void assemble(const std::vector<double>& c, BlockValues& K) const;

  double lambda_ = 0.0;
  double mu_ = 0.0;
  std::vector<Batch> batches_;
  std::vector<Edge> edges_;  ///< and one more, for the end of the terms
  std::vector<Term> terms_;
  std::vector<int> diagonal_;  ///< block (i, i)
};

}  // namespace tandem::fem
