#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/elements/corotational_kernel.h"
#include "fem_process/elements/formulation.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/material/material.h"
#include "fem_process/matrix/tet4.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// Constants of one element.
struct Tet4 : TetShape {
  Matrix12d K;  ///< V Bᵀ D B (N/m)
};

/// Simplified co-rotational linear tetrahedra [Marinkovic & Zehn 2012, eqs. (1)-(2)].
///   f_e = R K_e u,  u_i = Rᵀ (x_i − x_0) − (X_i − X_0),  R = polar(F),  K_R = Σ R K_e Rᵀ
/// x, X current and reference corners (m). K_R leaves out the derivative of R. For isotropic
/// material the force is the exact gradient of V (μ |U − I|² + λ/2 tr²(U − I)). Taking differences
/// to corner 0 keeps round-off independent of the distance from the world origin.
class CorotationalTet4 final : public Formulation {
 public:
  /// `team` makes evaluate(); null: the caller alone.
  CorotationalTet4(const TetMesh& mesh, const Material& material, ThreadTeam* team = nullptr);

  [[nodiscard]] const BlockPattern& pattern() const override { return pattern_; }
  int evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K) const override;
  [[nodiscard]] Eigen::VectorXd derivative(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                                           const Eigen::VectorXd& dx) const override;
  [[nodiscard]] Eigen::MatrixXd derivatives(const Eigen::VectorXd& x,
                                            const Eigen::MatrixXd& dx) const override;
  [[nodiscard]] double energy(const Eigen::VectorXd& x) const override;
  [[nodiscard]] std::vector<ElementResult> element_results(const Eigen::VectorXd& x) const override;

  [[nodiscard]] const std::vector<Tet4>& elements() const { return elements_; }

 private:
  struct Local {
    Eigen::Matrix3d R;
    Eigen::Matrix3d F;
    Vector12d u;  ///< co-rotated displacements (m)
    bool inverted = false;
  };
  [[nodiscard]] Local localise(const Tet4& element, const Eigen::VectorXd& x) const;

  Eigen::VectorXd X_;
  Matrix6d D_;
  BlockPattern pattern_;
  CorotationalKernel kernel_;
  std::vector<Tet4> elements_;
  ThreadTeam* team_;
};

}  // namespace tandem::fem
