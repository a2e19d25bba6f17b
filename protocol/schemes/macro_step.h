#pragma once

#include <cstdint>
#include <string>

#include "protocol/contract/subsystem.h"

namespace tandem {

/// How one macro step ended.
struct MacroStepEnd {
  Outcome outcome = Outcome::Failed;
  std::string message = "the macro step was not made";
  MotionSet motions;   ///< at t_n + H
  WrenchSet wrenches;  ///< at t_n + H, as the flexible side answered
  WrenchSet own;       ///< of them, what the flexible bodies exert; empty: all
  WrenchSet applied;   ///< the λ that moved the multibody side
  std::int32_t iterations = 0;
  double residual_N = 0.0;     ///< ‖Λ(M(λ)) − λ‖ of the last iteration
  bool out_of_budget = false;  ///< ended by coupling.max_evaluations, above the limit

  /// The flexible bodies' wrenches.
  [[nodiscard]] const WrenchSet& of_bodies() const { return own.empty() ? wrenches : own; }
};

}  // namespace tandem
