#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/elements/formulation.h"
#include "fem_process/elements/solid_element.h"
#include "fem_process/material/materials.h"

namespace tandem::fem {

/// Tetrahedra of N = 4 or 10 nodes for small displacements: f_int = K (x − X),
///   K_ij e_a = Σ V C : sym(e_a ∂N_jᵀ) ∂N_i/∂X.
/// A rotation of the body strains it: for motions well below 1 % of a radian only.
template <int N>
class LinearSolid final : public Formulation {
 public:
  LinearSolid(const TetMesh& mesh, const Materials& materials);

  [[nodiscard]] const BlockPattern& pattern() const override { return pattern_; }
  int evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K) const override;
  [[nodiscard]] Eigen::VectorXd derivative(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                                           const Eigen::VectorXd& dx) const override;
  [[nodiscard]] double energy(const Eigen::VectorXd& x) const override;
  [[nodiscard]] std::vector<ElementResult> element_results(const Eigen::VectorXd& x) const override;

 private:
  using Element = SolidElement<N>;

  Eigen::VectorXd X_;
  BlockPattern pattern_;
  Materials materials_;
  std::vector<Matrix6d> C_;  ///< one per material
  std::vector<Element> elements_;
  BlockValues K_;
};

extern template class LinearSolid<4>;
extern template class LinearSolid<10>;

}  // namespace tandem::fem
