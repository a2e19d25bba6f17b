#include "mbs_process/step_rule.h"

#include <algorithm>

namespace tandem::mbs {

StepRule whole_step(const Params& params) {
  return {.share = 1.0, .erp = params.erp, .cfm = params.cfm, .motor_cfm = params.cfm};
}

StepRule first_half(const Params& params) {
  return {.share = 0.5, .erp = params.erp, .cfm = 2.0 * params.cfm, .motor_cfm = 2.0 * params.cfm};
}

StepRule second_half(const Params& params, double h_s) {
  StepRule rule{.share = 0.5, .motor_cfm = 2.0 * params.cfm};
  if (params.cfm == 0.0 || params.bodies.empty()) return rule;
  double mass_kg = params.bodies.front().mass_kg;
  for (const BodyParams& body : params.bodies) mass_kg = std::min(mass_kg, body.mass_kg);
  const double resolved = params.cfm * mass_kg / h_s;  // ≫ 1: the joint is soft within a step
  const double s = resolved / (1.0 + (1.0 - params.erp) * resolved);
  rule.erp = s * params.erp;
  rule.cfm = std::max(2.0 * s * params.cfm, std::min(params.cfm, 1e-8 * h_s / mass_kg));
  return rule;
}

}  // namespace tandem::mbs
