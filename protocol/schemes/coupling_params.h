#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/contract/sim_time.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem {

enum class SchemeKind { ExplicitSerial, ExplicitParallel, Implicit, InterfaceNewton, Tlm };
/// The value is the degree of the polynomial.
enum class Prediction { Hold = 0, Linear = 1, Quadratic = 2 };
enum class Relaxation { Constant, Aitken, Anderson, IqnIls, IqnImvj };
/// Whether the sides are evaluated one after the other (Gauss–Seidel) or at once (Jacobi).
enum class Iteration { Serial, Parallel };
enum class OnNotConverged { Stop, Accept };

/// When a kept interface Jacobian is taken anew, see JacobianBlock.
/// Automatic: EveryStep, but Broyden where the side makes the macro step in several micro steps,
/// through which it would have to carry its derivatives.
enum class Refresh { EveryStep, EveryNSteps, Broyden, Automatic };

/// Section `coupling.jacobian`.
struct JacobianParams {
  Refresh mbs_refresh = Refresh::EveryStep;
  Refresh fem_refresh = Refresh::Automatic;
  std::int32_t every_steps = 10;  ///< n of EveryNSteps
};

/// Section `coupling.retained_inertia`, see RetainedInertia.
struct RetainedInertiaParams {
  double factor = 0.0;  ///< part of the flexible side's inertia that is retained, 0 = off
  std::int32_t refresh_steps = 0;  ///< macro steps after which it is taken anew, 0 = never
};

/// Section `coupling.tlm`, see TransmissionLine.
struct TlmParams {
  double stiffness_N_per_m = 1e4;  ///< of the line at each port
};

/// Section `coupling.adaptive`, see StepController.
struct AdaptiveParams {
  double tolerance = 0.0;           ///< of a macro step's error; 0 = fixed steps
  std::optional<SimTime> min_step;  ///< and the unit of all steps; none = run.macro_step / 32
  std::optional<SimTime> max_step;  ///< none = 32 run.macro_step
  [[nodiscard]] bool active() const { return tolerance > 0.0; }
};

/// Section `coupling.quasi_newton`.
struct QuasiNewtonParams {
  std::int32_t reused_steps = 8;  ///< accepted macro steps whose columns IQN-ILS keeps
  /// A column is left out when its part that is new to the newer ones is less than this part of it.
  double filter = 1e-3;
};

/// Section `coupling` of a scenario. Defaults stand here alone; the key table prints them.
struct CouplingParams {
  static constexpr double kFixedStepTolerance = 1e-12;
  /// Of interface_jacobian: Newton's method leaves an error of the residual's size, a fixed-point
  /// iteration one of several times that.
  static constexpr double kNewtonTolerance = 1e-11;

  SchemeKind scheme = SchemeKind::InterfaceNewton;
  Prediction prediction = Prediction::Linear;         ///< of the wrenches
  Prediction motion_prediction = Prediction::Linear;  ///< of the motions, in parallel schemes
  std::int32_t max_iterations = 50;
  /// Evaluations after which a macro step ends as it is, its residual booked; 0: none.
  std::int32_t max_evaluations = 0;
  /// Converged when ‖r‖ ≤ tolerance_N + relative_tolerance · max ‖λ‖ with r = Λ(M(λ)) − λ, the
  /// largest wrench up to now, and torques scaled by the port lengths. No number of newtons is
  /// small for every model: the absolute part is none unless the scenario sets it, and where the
  /// wrench vanishes round-off ends the step.
  double tolerance_N = 0.0;
  double relative_tolerance = kFixedStepTolerance;
  /// Absolute part of the velocity residual of parallel iterations that counts as converged; none
  /// unless the scenario sets it, see Implicit.
  double tolerance_m_per_s = 0.0;
  Iteration iteration = Iteration::Serial;
  Relaxation relaxation = Relaxation::Aitken;
  double relaxation_factor = 0.5;  ///< constant factor, or Aitken's first one
  QuasiNewtonParams quasi_newton;
  JacobianParams jacobian;
  RetainedInertiaParams retained_inertia;
  TlmParams tlm;
  AdaptiveParams adaptive;
  OnNotConverged on_not_converged = OnNotConverged::Stop;
  /// A run has diverged when the interface energy defect of a macro step has grown by this factor
  /// over consecutive macro steps in which ‖r‖ > ‖λ‖/2 (see DivergenceMonitor).
  double divergence_growth = 1e3;
};

[[nodiscard]] std::string to_string(SchemeKind kind);
[[nodiscard]] std::string to_string(Prediction prediction);

/// Whether a macro step ends after the k-th evaluation though its residual is above the limit.
[[nodiscard]] inline bool ends_on_budget(const CouplingParams& params, std::int32_t k) {
  return params.max_evaluations > 0 && k >= params.max_evaluations;
}

/// What is set and has no effect with the scheme, one sentence each.
[[nodiscard]] std::vector<std::string> notes_of(const CouplingParams& params);
[[nodiscard]] scenario::Key coupling_keys();
[[nodiscard]] CouplingParams read_coupling(const scenario::Node& root);

}  // namespace tandem
