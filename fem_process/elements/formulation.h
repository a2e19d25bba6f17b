#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/matrix/block_matrix.h"

namespace tandem::fem {

/// What a formulation says of one element, for output.
struct ElementResult {
  double von_mises_Pa = 0.0;
  double rotation_rad = 0.0;
};

/// Internal forces of the mesh as a function of the nodal positions. Const after construction: the
/// integrators, the solvers and the body do not know which formulation they run.
class Formulation {
 public:
  virtual ~Formulation() = default;

  [[nodiscard]] virtual const BlockPattern& pattern() const = 0;

  /// f_int(x) (N, 3 per node) and the stiffness K(x) (N/m) that the step matrix and Rayleigh
  /// damping use. Returns the number of inverted elements (det F ≤ 0).
  virtual int evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K) const = 0;

  /// Exact directional derivative (N) of f_int(x) + K(x) y along dx, y held: what K itself leaves
  /// out (the turning of the elements) included.
  [[nodiscard]] virtual Eigen::VectorXd derivative(const Eigen::VectorXd& x,
                                                   const Eigen::VectorXd& y,
                                                   const Eigen::VectorXd& dx) const = 0;

  /// The same with y = 0 along many directions, a column each.
  [[nodiscard]] virtual Eigen::MatrixXd derivatives(const Eigen::VectorXd& x,
                                                    const Eigen::MatrixXd& dx) const {
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(x.size());
    Eigen::MatrixXd changes(dx.rows(), dx.cols());
    for (Eigen::Index c = 0; c < dx.cols(); ++c) changes.col(c) = derivative(x, none, dx.col(c));
    return changes;
  }

  /// Strain energy (J).
  [[nodiscard]] virtual double energy(const Eigen::VectorXd& x) const = 0;

  [[nodiscard]] virtual std::vector<ElementResult> element_results(
      const Eigen::VectorXd& x) const = 0;
};

}  // namespace tandem::fem
