#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/block_matrix.h"
#include "fem_process/simd.h"
#include "fem_process/tet4.h"
#include "fem_process/thread_team.h"

namespace tandem::fem {

/// Sums what isotropic co-rotational tetrahedra give to their nodes and edges. With c_i = √V R ∇N_i
/// and f_i the force of a corner of an element,
///   f_int,i = Σ f_i,   K_ij = λ D_ij + μ D_ijᵀ + μ tr D_ij I,   D_ij = Σ c_i c_jᵀ,
/// the sums over the elements around a node or an edge, in the order of the mesh. Every row is
/// gathered by one thread: the same bits for any number of them.
class Tet4Assembly {
 public:
  /// Lamé's constants in Pa.
  Tet4Assembly(const std::vector<TetShape>& shapes, const BlockPattern& pattern, double lambda,
               double mu);

  /// c (√m/… as above) and forces (N) of corner i of element e at 4 e + i. Sets f_int (N, 3 per
  /// node) and K (N/m).
  void gather(const std::vector<Padded>& c, const std::vector<Padded>& f, Eigen::VectorXd& f_int,
              BlockValues& K, ThreadTeam& team) const;

  /// Block (i, j), i < j, and its transpose.
  struct Edge {
    int upper = 0;       ///< block (i, j)
    int lower = 0;       ///< block (j, i)
    int first_term = 0;  ///< its last term is before the next edge's first
  };
  struct Term {
    int i = 0;  ///< corner of an element that stands at node i
    int j = 0;
  };
  struct Row {
    int diagonal = 0;      ///< block (i, i)
    int first_corner = 0;  ///< in corners
    int first_edge = 0;    ///< in edges
  };
  /// The lists; each ends with one more entry, for the end of what belongs to the last.
  struct Lists {
    std::vector<Row> rows;
    std::vector<int> corners;
    std::vector<Edge> edges;
    std::vector<Term> terms;
  };

 private:
  double lambda_;
  double mu_;
  Lists lists_;
};

}  // namespace tandem::fem
