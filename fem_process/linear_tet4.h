#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/formulation.h"
#include "fem_process/material.h"
#include "fem_process/tet4.h"

namespace tandem::fem {

/// Linear tetrahedra of small displacements: f_int = K (x − X), K = Σ V Bᵀ D B. A rotation of the
/// body strains it: for motions well below 1 % of a radian only.
class LinearTet4 final : public Formulation {
 public:
  LinearTet4(const TetMesh& mesh, const Material& material);

  [[nodiscard]] const BlockPattern& pattern() const override { return pattern_; }
  int evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K) const override;
  [[nodiscard]] Eigen::VectorXd derivative(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                                           const Eigen::VectorXd& dx) const override;
  [[nodiscard]] double energy(const Eigen::VectorXd& x) const override;
  [[nodiscard]] std::vector<ElementResult> element_results(const Eigen::VectorXd& x) const override;

 private:
  Eigen::VectorXd X_;
  Matrix6d D_;
  BlockPattern pattern_;
  std::vector<TetShape> shapes_;
  BlockValues K_;
};

}  // namespace tandem::fem
