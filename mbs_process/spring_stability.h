#pragma once

#include <optional>
#include <string>

#include "mbs_process/params.h"

namespace tandem::mbs {

/// What explicit springs and dampers make of a micro step h. Their efforts are those of its
/// beginning, so with the mass m that it moves one spring is stable while
///   h² k / m + 2 h c / m ≤ 4.
/// For several, with the rates' response A (1/kg) to their efforts, measured by one dWorldStep each
/// (so joints and levers count), it is the largest eigenvalue of √D A √D, D = h² K + 2 h C.
/// Efforts along the mechanism's own directions at t = 0 alone; the flexible body's inertia, which
/// would help, is left out.
struct SpringStability {
  double number = 0.0;         ///< largest eigenvalue; 0 without springs
  std::string spring;          ///< the one with the largest part in it
  double stable_step_s = 0.0;  ///< h at which the number is 4
  [[nodiscard]] bool stable() const { return number <= 4.0; }
};

/// At the micro step of `params`, as RigidWorld::params() has them. Cost: an OdeWorld and a step of
/// it for each spring and damper.
[[nodiscard]] SpringStability spring_stability(const Params& params);

/// "spring 'a' is too stiff for …" with the remedy; nothing while all are stable.
[[nodiscard]] std::optional<std::string> spring_warning(const Params& params);

}  // namespace tandem::mbs
