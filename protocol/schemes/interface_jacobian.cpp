#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/scheme.h"

namespace tandem {

InterfaceJacobianScheme::InterfaceJacobianScheme(const CouplingParams& params,
                                                 std::vector<PortInfo> ports)
    : params_(params), ports_(std::move(ports)) {}

MacroStepEnd InterfaceJacobianScheme::advance(SimTime H, const InterfaceState& state, MbsSide& mbs,
                                              FemSide& fem) {
  WrenchSet lambda = predict(params_.prediction, state);
  Eigen::PartialPivLU<Eigen::MatrixXd> newton_matrix;
  for (std::int32_t k = 1;; ++k) {
    if (k > 1) roll_back(mbs, fem);
    const Evaluation evaluation = evaluate(H, state, lambda, k == 1, mbs, fem, ports_);
    MacroStepEnd end = end_of(evaluation, lambda, k);
    if (end.outcome == Outcome::Failed || !std::isfinite(end.residual_N)) return end;
    if (end.residual_N <= residual_limit_N(params_, evaluation)) return end;
    if (k == params_.max_iterations) {
      end.outcome = Outcome::NotConverged;
      end.message = fmt::format(
          "interface_jacobian: ‖r‖ = {:.3g} N after {} iterations, limit {:.3g} N. The sides are "
          "not affine in the port quantities here (contact, joint limits, large rotation per "
          "step): "
          "lower run.macro_step_s or raise coupling.max_iterations. A stiff mesh can also leave a "
          "residual of round-off that no iteration removes: raise coupling.tolerance_N above it.",
          end.residual_N, k, residual_limit_N(params_, evaluation));
      return end;
    }
    if (k == 1) {
      // r(λ + δ) ≈ r(λ) + (L B − I) δ = 0.
      const Eigen::Index n = evaluation.residual.size();
      newton_matrix.compute(Eigen::MatrixXd::Identity(n, n) -
                            evaluation.fem_jacobian * evaluation.mbs_jacobian);
    }
    lambda = unstack_wrenches(stack(lambda) + newton_matrix.solve(evaluation.residual));
  }
}

}  // namespace tandem
