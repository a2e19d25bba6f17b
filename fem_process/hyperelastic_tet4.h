#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/formulation.h"
#include "fem_process/stress_law.h"
#include "fem_process/tet4.h"

namespace tandem::fem {

/// Linear tetrahedra of hyperelastic material in total Lagrangian form:
///   F = Σ x_i ∂N_i/∂X,  f_i = V P(F) ∂N_i/∂X,  K_ij e_a = V DP[e_a ∂N_jᵀ] ∂N_i/∂X.
/// K is the exact derivative of f (for a law that has a potential; else its symmetric part), so
/// that Newton's iteration converges quadratically.
template <class Law>
class HyperelasticTet4 final : public Formulation {
 public:
  HyperelasticTet4(const TetMesh& mesh, const Material& material);

  [[nodiscard]] const BlockPattern& pattern() const override { return pattern_; }
  int evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K) const override;
  [[nodiscard]] Eigen::VectorXd derivative(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                                           const Eigen::VectorXd& dx) const override;
  [[nodiscard]] double energy(const Eigen::VectorXd& x) const override;
  [[nodiscard]] std::vector<ElementResult> element_results(const Eigen::VectorXd& x) const override;

 private:
  [[nodiscard]] Matrix12d stiffness(const TetShape& shape, const typename Law::Point& point) const;

  BlockPattern pattern_;
  Law law_;
  std::vector<TetShape> shapes_;
};

/// `corotational_consistent`: the co-rotational element with the rotation's derivative.
using ConsistentCorotationalTet4 = HyperelasticTet4<CorotatedLaw>;
/// `total_lagrangian`: the rigorous geometrically nonlinear reference.
using TotalLagrangianTet4 = HyperelasticTet4<StVenantKirchhoffLaw>;

}  // namespace tandem::fem
