#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/kernels/simd.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/assembly_lists.h"
#include "fem_process/matrix/block_matrix.h"
#include "fem_process/matrix/tet4.h"

namespace tandem::fem {

/// Sums what isotropic co-rotational tetrahedra give to their nodes and edges. With c_i = √V R ∇N_i
/// and f_i the force of a corner of an element,
///   f_int,i = Σ f_i,   K_ij = λ D_ij + μ D_ijᵀ + μ tr D_ij I,   D_ij = Σ c_i c_jᵀ,
/// the sums over the elements around a node or an edge, in the order of the mesh, wherever their
/// parts stand. Every row is gathered by one thread: the same bits for any number of them.
class Tet4Assembly {
 public:
  /// Parts of element e stand at slot[e]; rows are worked in the order of `nodes`. Both lists, of
  /// elements and nodes, keep what is near together, or the gathering of a large mesh waits for
  /// memory. Lamé's constants in Pa.
  Tet4Assembly(const std::vector<TetShape>& shapes, const std::vector<int>& slot,
               const std::vector<int>& nodes, const BlockPattern& pattern, double lambda,
               double mu);

  /// c (√m/… as above) and forces (N) of corner i of the element at slot s at 4 s + i. Sets f_int
  /// (N, 3 per node) and K (N/m).
  void gather(const std::vector<Padded>& c, const std::vector<Padded>& f, Eigen::VectorXd& f_int,
              BlockValues& K, ThreadTeam& team) const;

 private:
  double lambda_;
  double mu_;
  AssemblyLists lists_;
};

}  // namespace tandem::fem
