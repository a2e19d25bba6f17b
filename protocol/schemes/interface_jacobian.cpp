#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/scheme.h"

namespace tandem {

InterfaceJacobianScheme::InterfaceJacobianScheme(const CouplingParams& params,
                                                 std::vector<PortInfo> ports)
    : params_(params), ports_(std::move(ports)) {}

namespace {

/// Round-off of the flexible side's wrench (N): what the rounding of its input, |m| times the
/// machine's precision, does to it through L. A stiff body that takes positions cannot be iterated
/// below it. Angles are rounded as numbers of the size of one.
double wrench_round_off_N(const Evaluation& evaluation, const std::vector<PortInfo>& ports) {
  Eigen::VectorXd rounded(12 * static_cast<Eigen::Index>(ports.size()));
  for (std::size_t p = 0; p < ports.size(); ++p) {
    const Motion& m = evaluation.motions[p];
    rounded.segment<12>(12 * static_cast<Eigen::Index>(p))
        << m.p_WP.cwiseAbs().array() + ports[p].length_m,
        Eigen::Vector3d::Ones(), m.v_WP.cwiseAbs(), m.w_WP.cwiseAbs();
  }
  rounded *= 4.0 * std::numeric_limits<double>::epsilon();
  return wrench_norm_N(unstack_wrenches(evaluation.fem_jacobian.cwiseAbs() * rounded), ports);
}

}  // namespace

MacroStepEnd InterfaceJacobianScheme::advance(SimTime H, const InterfaceState& state, MbsSide& mbs,
                                              FemSide& fem) {
  WrenchSet lambda = predict(params_.prediction, state);
  Eigen::PartialPivLU<Eigen::MatrixXd> newton_matrix;
  double round_off_N = 0.0;
  for (std::int32_t k = 1;; ++k) {
    if (k > 1) roll_back(mbs, fem);
    const Evaluation evaluation = evaluate(H, state, lambda, k == 1, mbs, fem, ports_);
    MacroStepEnd end = end_of(evaluation, lambda, k);
    if (end.outcome == Outcome::Failed || !std::isfinite(end.residual_N)) return end;
    if (k == 1) round_off_N = wrench_round_off_N(evaluation, ports_);
    const double limit_N = residual_limit_N(params_, evaluation) + round_off_N;
    if (end.residual_N <= limit_N) return end;
    if (k == params_.max_iterations) {
      end.outcome = Outcome::NotConverged;
      end.message = fmt::format(
          "interface_jacobian: ‖r‖ = {:.3g} N after {} iterations, limit {:.3g} N. The sides are "
          "not affine in the port quantities here (contact, joint limits, large rotation per "
          "step): "
          "lower run.macro_step_s or raise coupling.max_iterations.",
          end.residual_N, k, limit_N);
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
