#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "fem_process/elements/formulation.h"
#include "fem_process/elements/hyperelastic.h"
#include "fem_process/elements/tet10_kernel.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/material/material.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// SimplifiedCorotational<10> of one isotropic material, all but its output by Tet10Kernel: the
/// same but for round-off, eight elements at a time and on several threads.
class CorotationalTet10 final : public Formulation {
 public:
  /// `team` shares the loops over elements; null: the caller alone.
  CorotationalTet10(const TetMesh& mesh, const Material& material, ThreadTeam* team = nullptr);

  [[nodiscard]] const BlockPattern& pattern() const override { return general_.pattern(); }
  int evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K) const override;
  [[nodiscard]] Eigen::VectorXd derivative(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                                           const Eigen::VectorXd& dx) const override;
  [[nodiscard]] Eigen::MatrixXd derivatives(const Eigen::VectorXd& x,
                                            const Eigen::MatrixXd& dx) const override;
  [[nodiscard]] double energy(const Eigen::VectorXd& x) const override;
  [[nodiscard]] std::vector<ElementResult> element_results(const Eigen::VectorXd& x) const override;

 private:
  SimplifiedCorotational<10> general_;
  Tet10Kernel kernel_;
  std::unique_ptr<ThreadTeam> alone_;  ///< the caller, without a team
  ThreadTeam* team_;
};

}  // namespace tandem::fem
