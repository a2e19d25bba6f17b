#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/elements/solid_element.h"
#include "fem_process/kernels/simd.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/assembly_lists.h"
#include "fem_process/matrix/block_matrix.h"

namespace tandem::fem {

/// Four 3-vectors of a node of an element, component by component.
struct alignas(32) FourVectors {
  double at[3][4];
};

/// Sums what isotropic co-rotational tetrahedra of ten nodes give to their nodes and pairs of
/// nodes. With c_i = √V R ∇N_i at the four integration points of an element, side by side, and f_i
/// the force of a node,
///   f_int,i = Σ f_i,   K_ij = λ D_ij + μ D_ijᵀ + μ tr D_ij I,   D_ij = Σ c_i c_jᵀ,
/// the sums over the elements in the order of the mesh and over the integration points in each.
/// Every row is gathered by one thread: the same bits for any number of them.
class Tet10Assembly {
 public:
  /// Lamé's constants in Pa.
  Tet10Assembly(const std::vector<SolidElement<10>>& elements, const BlockPattern& pattern,
                double lambda, double mu);

  /// c (√m/… as above) and forces (N) of node i of element e at 10 e + i. Sets f_int (N, 3 per
  /// node) and K (N/m).
  void gather(const std::vector<FourVectors>& c, const std::vector<Padded>& f,
              Eigen::VectorXd& f_int, BlockValues& K, ThreadTeam& team) const;

  /// Adds up the forces of four loads, side by side, at the nodes of the elements. Sets `count`
  /// columns of `sums` (N) from `first` on.
  void gather_forces(const std::vector<FourVectors>& f, Eigen::MatrixXd& sums, Eigen::Index first,
                     Eigen::Index count, ThreadTeam& team) const;

 private:
  double lambda_;
  double mu_;
  AssemblyLists lists_;
};

}  // namespace tandem::fem
