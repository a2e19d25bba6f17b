#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "protocol/schemes/scheme.h"

namespace tandem {

/// One iteration: both sides evaluated from t_n with the wrench λ at the end of the macro step.
struct Evaluation {
  Outcome outcome = Outcome::Failed;  ///< the worse of both sides' outcomes
  std::string message;
  MotionSet motions;  ///< M(λ)
  MotionSet seen;     ///< m̂ that the flexible side was shown: M(λ) unless that is far out
  WrenchSet wrenches;
  WrenchSet own;                ///< of them, what the flexible bodies exert; empty: all
  Eigen::VectorXd residual;     ///< Λ(m̂) − λ, stacked
  double residual_N = 0.0;      ///< its scaled norm
  double wrench_N = 0.0;        ///< scaled norm of Λ(m̂), of what is the bodies' own
  double output_error_N = 0.0;  ///< of Λ(m̂), as the flexible side says
  bool apart = false;           ///< m̂ is not M(λ): no end of a macro step
  InterfaceJacobian mbs_jacobian;
  InterfaceJacobian fem_jacobian;
};

/// Which sides return their interface Jacobians with an evaluation.
struct Linearize {
  bool mbs = false;
  bool fem = false;
};

/// m = M(λ), Λ = Λ(m). Stops after the first side that fails. A side that is asked to linearise and
/// cannot makes this a Usage error.
[[nodiscard]] Evaluation evaluate(SimTime H, const InterfaceState& state, const WrenchSet& lambda,
                                  Linearize linearize, MbsSide& mbs, FemSide& fem,
                                  const std::vector<PortInfo>& ports);

/// The first evaluation of a Newton iteration, both sides linearised as asked for. A wrench that is
/// off by Δλ moves a light body m by H² Δλ/m, so M(λ predicted) may be far out where the port never
/// comes, and the flexible side's derivative there is worth nothing. So where M(λ) is more than
/// kFarOut from the motions that the past predicts, and by far more than such a prediction missed
/// in the last macro step, the flexible side is shown the predicted motions: m̂.
[[nodiscard]] Evaluation evaluate_first(SimTime H, const InterfaceState& state,
                                        const WrenchSet& lambda, Prediction motions,
                                        Linearize linearize, MbsSide& mbs, FemSide& fem,
                                        const std::vector<PortInfo>& ports);

/// Angle (rad), and part of the port's length, from which on it is.
constexpr double kFarOut = 1e-3;

/// Whether an iterate has led a port astray: turned it by more than a radian away from `expected`.
/// Attitudes repeat after a full turn, so r(λ) = 0 has further solutions there, in which the sides
/// meet again after some turns within one step. A search that sees one keeps it, and the run goes
/// on with a thousandfold energy. By the velocities at the end of the step, which do not repeat.
[[nodiscard]] bool led_astray(SimTime H, const MotionSet& expected, const MotionSet& motions);

/// r(λ) of Newton's step δλ = (I − L B)⁻¹ r: Λ(m̂) + L (M(λ) − m̂) − λ.
[[nodiscard]] Eigen::VectorXd newton_residual(const Evaluation& evaluation,
                                              const InterfaceJacobian& fem);

/// The answers of both sides as one evaluation; λ is what moved the multibody side.
[[nodiscard]] Evaluation joined(const StepResult<MotionSet>& mbs, const StepResult<WrenchSet>& fem,
                                const WrenchSet& lambda, const std::vector<PortInfo>& ports);

/// m = M(λ) and Λ = Λ(m̂), both sides at the same time. The residual is Λ(m̂) − λ.
[[nodiscard]] Evaluation evaluate_parallel(SimTime H, const InterfaceState& state,
                                           const WrenchSet& lambda, const MotionSet& motions,
                                           MbsSide& mbs, FemSide& fem,
                                           const std::vector<PortInfo>& ports);

/// Restores both sides to t_n before a further iteration.
void roll_back(MbsSide& mbs, FemSide& fem);

/// Tolerance of the residual: tolerance_N + relative_tolerance max ‖Λ‖, of the present wrench and
/// of `largest_N`, the largest one accepted so far: a wrench that passes through zero keeps its
/// scale.
[[nodiscard]] double residual_limit_N(const CouplingParams& params, const Evaluation& evaluation,
                                      double largest_N);

/// The evaluation as the end of a macro step.
[[nodiscard]] MacroStepEnd end_of(const Evaluation& evaluation, const WrenchSet& applied,
                                  std::int32_t iterations);

/// Round-off of the flexible side's wrench (N): what the rounding of its input, |m| times the
/// machine's precision, does to it through L = ∂Λ/∂m. A stiff body that takes positions cannot be
/// iterated below it. Angles are rounded as numbers of the size of one.
[[nodiscard]] double wrench_round_off_N(const MotionSet& motions, const InterfaceJacobian& fem,
                                        const std::vector<PortInfo>& ports);

/// What the rounding of poses makes of the wrench where the side turns velocities into positions,
/// N: ε (|p| + ℓ)/H and ε/H through ∂Λ/∂(v, w). A stiff side feels it, its nodes being rounded
/// there; a heavy one does not. How much of it there is L does not tell: it bounds round-off, no
/// more.
[[nodiscard]] double pose_round_off_N(SimTime H, const MotionSet& motions,
                                      const InterfaceJacobian& fem,
                                      const std::vector<PortInfo>& ports);

/// Whether a residual that was not brought below its limit looks like round-off of that size: then
/// no shorter step and no further iteration helps, but a tolerance above it.
[[nodiscard]] bool looks_like_round_off(double residual_N, double round_off_N);
/// What to say where a residual is rather what the flexible side's own solver leaves in the wrench
/// (`solver_N`) than round-off.
[[nodiscard]] std::optional<std::string> solver_remedy(double residual_N, double round_off_N,
                                                       double solver_N);

}  // namespace tandem
