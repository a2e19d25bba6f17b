#include "mbs_process/wrench_rule.h"

namespace tandem::mbs {

WrenchSet WrenchRule::filtered(const WrenchSet& before, const WrenchSet& begin,
                               const WrenchSet& end) const {
  if (alpha_m == 0.0 && alpha_f == 0.0) return end;
  const Eigen::VectorXd balance = (1.0 - alpha_f) * stack(end) + alpha_f * stack(begin);
  return unstack_wrenches((balance - alpha_m * stack(before)) / (1.0 - alpha_m));
}

WrenchSet WrenchRule::first_half(const WrenchSet& before, const WrenchSet& after) const {
  const Eigen::VectorXd begin = stack(before);
  return unstack_wrenches(begin + 2.0 * beta * (stack(after) - begin));
}

WrenchSet WrenchRule::second_half(const WrenchSet& before, const WrenchSet& after) const {
  const Eigen::VectorXd begin = stack(before);
  const Eigen::VectorXd end = stack(after);
  // Of the form that is exact for equal weights: λ + λ⁺ less the first half.
  const Eigen::VectorXd sum = (begin + end) + (2.0 * gamma - 1.0) * (end - begin);
  return unstack_wrenches(sum - stack(first_half(before, after)));
}

namespace {

/// Of Chung and Hulbert.
WrenchRule rule_of(double rho) {
  WrenchRule rule;
  rule.alpha_m = (2.0 * rho - 1.0) / (rho + 1.0);
  rule.alpha_f = rho / (rho + 1.0);
  const double shift = 1.0 - rule.alpha_m + rule.alpha_f;
  rule.gamma = shift - 0.5;
  rule.beta = 0.25 * shift * shift;
  return rule;
}

/// Kept of a junction's imbalance in a step of verlet.
constexpr double kJunctionRho = 0.5;

}  // namespace

WrenchRule wrench_rule(const Params& params) {
  if (params.integrator != IntegratorKind::GeneralisedAlpha) return {.beta = params.newmark_beta};
  return rule_of(params.rho_infinity);
}

WrenchRule junction_rule(const Params& params) {
  return params.integrator == IntegratorKind::Verlet ? rule_of(kJunctionRho) : wrench_rule(params);
}

}  // namespace tandem::mbs
