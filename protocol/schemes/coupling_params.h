#pragma once

#include <cstdint>
#include <string>

#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem {

enum class SchemeKind { ExplicitSerial, Implicit, InterfaceNewton };
enum class Prediction { Hold, Linear };
enum class Relaxation { Constant, Aitken };
enum class OnNotConverged { Stop, Accept };

/// Section `coupling` of a scenario. Defaults stand here alone; the key table prints them.
struct CouplingParams {
  SchemeKind scheme = SchemeKind::InterfaceNewton;
  Prediction prediction = Prediction::Linear;
  std::int32_t max_iterations = 50;
  /// Converged when ‖r‖ ≤ tolerance_N + relative_tolerance · ‖λ‖ with r = Λ(M(λ)) − λ and torques
  /// scaled by the port lengths.
  double tolerance_N = 1e-11;
  double relative_tolerance = 1e-12;
  Relaxation relaxation = Relaxation::Aitken;
  double relaxation_factor = 0.5;  ///< constant factor, or Aitken's first one
  OnNotConverged on_not_converged = OnNotConverged::Stop;
  /// A run has diverged when the interface energy defect of a macro step has grown by this factor
  /// over consecutive macro steps in which ‖r‖ > ‖λ‖/2 (see DivergenceMonitor).
  double divergence_growth = 1e3;
};

[[nodiscard]] std::string to_string(SchemeKind kind);
[[nodiscard]] scenario::Key coupling_keys();
[[nodiscard]] CouplingParams read_coupling(const scenario::Node& root);

}  // namespace tandem
