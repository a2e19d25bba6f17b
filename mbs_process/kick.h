#pragma once

#include <array>
#include <vector>

#include "mbs_process/ode_world.h"
#include "mbs_process/state.h"
#include "mbs_process/step_rule.h"

namespace tandem::mbs {

/// One dWorldStep: what it began with, and where it led.
struct Kick {
  double h_s = 0.0;
  StepRule rule;
  std::vector<BodyState> begin;
  std::vector<std::array<double, 2>> coordinates;  ///< of the joints, that stops went by
  std::vector<BodyWrench> applied;                 ///< of which it took rule.share
  std::vector<EffortRow> efforts;
  std::vector<BodyState> end;  ///< pose and twist that ODE made
};

}  // namespace tandem::mbs
