#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/elements/formulation.h"
#include "fem_process/elements/solid_element.h"
#include "fem_process/material/materials.h"
#include "fem_process/material/stress_law.h"

namespace tandem::fem {

/// Tetrahedra of N = 4 or 10 nodes of hyperelastic materials in total Lagrangian form, summed over
/// the integration points of volume V:
///   F = Σ x_i ∂N_i/∂X,  f_i = Σ V P(F) ∂N_i/∂X,  K_ij e_a = Σ V A[e_a ∂N_jᵀ] ∂N_i/∂X.
/// With the exact tangent A = DP, K is the exact derivative of f (for a law that has a potential;
/// else its symmetric part), so that Newton's iteration converges quadratically.
/// With the co-rotated law the rotation is taken at every integration point: f is then the exact
/// gradient of an energy in elements of any order, and an element may bend by any angle.
template <class Law, class Tangent, int N>
class Hyperelastic final : public Formulation {
 public:
  Hyperelastic(const TetMesh& mesh, const Materials& materials);

  [[nodiscard]] const BlockPattern& pattern() const override { return pattern_; }
  int evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K) const override;
  [[nodiscard]] Eigen::VectorXd derivative(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                                           const Eigen::VectorXd& dx) const override;
  [[nodiscard]] double energy(const Eigen::VectorXd& x) const override;
  [[nodiscard]] std::vector<ElementResult> element_results(const Eigen::VectorXd& x) const override;

  using Element = SolidElement<N>;
  [[nodiscard]] const std::vector<Element>& elements() const { return elements_; }

 private:
  [[nodiscard]] static typename Element::Tangent tangent(const Law& law,
                                                         const typename Law::Point& point);
  [[nodiscard]] const Law& law(std::size_t element) const {
    return laws_[materials_.index(element)];
  }

  BlockPattern pattern_;
  Materials materials_;
  std::vector<Law> laws_;  ///< one per material
  std::vector<Element> elements_;
};

/// `corotational`: the simplified tangent R C Rᵀ of [Marinkovic & Zehn 2012].
template <int N>
using SimplifiedCorotational = Hyperelastic<CorotatedLaw, SimplifiedTangent, N>;
/// `corotational_consistent`: the tangent with the rotation's derivative.
template <int N>
using ConsistentCorotational = Hyperelastic<CorotatedLaw, ExactTangent, N>;
/// `total_lagrangian`: the rigorous geometrically nonlinear reference.
template <int N>
using TotalLagrangian = Hyperelastic<StVenantKirchhoffLaw, ExactTangent, N>;

}  // namespace tandem::fem
