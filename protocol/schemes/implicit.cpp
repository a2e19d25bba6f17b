#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/scheme.h"

namespace tandem {
namespace {

/// a·b with torques scaled by the port length squared: the inner product of wrench_norm_N.
double scaled_dot(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                  const std::vector<PortInfo>& ports) {
  double sum = 0.0;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const auto row = 6 * static_cast<Eigen::Index>(i);
    sum += a.segment<3>(row).dot(b.segment<3>(row));
    sum +=
        a.segment<3>(row + 3).dot(b.segment<3>(row + 3)) / (ports[i].length_m * ports[i].length_m);
  }
  return sum;
}

/// Aitken's factor from two successive residuals. Kept within [1e-4, 2] in size: an accidental near
/// equality of two residuals must not throw the iterate out of the region where the sides converge.
double aitken_factor(double omega, const Eigen::VectorXd& r_old, const Eigen::VectorXd& r,
                     const std::vector<PortInfo>& ports) {
  const Eigen::VectorXd change = r - r_old;
  const double denominator = scaled_dot(change, change, ports);
  if (!(denominator > 0.0)) return omega;
  const double next = -omega * scaled_dot(r_old, change, ports) / denominator;
  return std::copysign(std::clamp(std::abs(next), 1e-4, 2.0), next);
}

std::string not_converged_text(const CouplingParams& params, const Evaluation& evaluation) {
  return fmt::format(
      "implicit: ‖r‖ = {:.3g} N after {} iterations, limit {:.3g} N. Raise "
      "coupling.max_iterations, lower coupling.relaxation_factor or run.macro_step_s, or use "
      "coupling.scheme: interface_jacobian.",
      evaluation.residual_N, params.max_iterations, residual_limit_N(params, evaluation));
}

}  // namespace

Implicit::Implicit(const CouplingParams& params, std::vector<PortInfo> ports)
    : params_(params), ports_(std::move(ports)) {}

MacroStepEnd Implicit::advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) {
  WrenchSet lambda = predict(params_.prediction, state);
  double omega = params_.relaxation_factor;
  Eigen::VectorXd previous_residual;
  for (std::int32_t k = 1;; ++k) {
    if (k > 1) roll_back(mbs, fem);
    const Evaluation evaluation = evaluate(H, state, lambda, false, mbs, fem, ports_);
    MacroStepEnd end = end_of(evaluation, lambda, k);
    if (end.outcome == Outcome::Failed || !std::isfinite(end.residual_N)) return end;
    if (end.residual_N <= residual_limit_N(params_, evaluation)) return end;
    if (k == params_.max_iterations) {
      end.outcome = Outcome::NotConverged;
      end.message = not_converged_text(params_, evaluation);
      return end;
    }
    if (params_.relaxation == Relaxation::Aitken && k > 1) {
      omega = aitken_factor(omega, previous_residual, evaluation.residual, ports_);
    }
    previous_residual = evaluation.residual;
    lambda = unstack_wrenches(stack(lambda) + omega * evaluation.residual);
  }
}

}  // namespace tandem
