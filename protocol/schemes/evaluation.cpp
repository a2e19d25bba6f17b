#include "protocol/schemes/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "protocol/contract/error.h"

namespace tandem {
namespace {

/// Joins one side's outcome into the evaluation; false when the side failed. The sides' messages
/// name themselves.
template <class Result>
bool take_outcome(const Result& result, Evaluation& evaluation) {
  evaluation.outcome = std::max(evaluation.outcome, result.outcome);
  if (result.outcome != Outcome::Done) {
    if (!evaluation.message.empty()) evaluation.message += " ";
    evaluation.message += result.message;
  }
  return result.outcome != Outcome::Failed;
}

template <class Result>
InterfaceJacobian take_jacobian(const char* side, const Result& result) {
  require(result.jacobian.has_value(),
          std::string("coupling.scheme and its options need the interface Jacobian of the ") +
              side + " side, which has none. Use implicit or explicit_serial.");
  return *result.jacobian;
}

/// Prediction errors of a port's motion that a wrench must have led it away by.
constexpr double kTimesExpected = 10.0;

/// The motions that were predicted for t_n, one macro step ago; none while the run is young.
std::optional<MotionSet> predicted_before(Prediction prediction, const InterfaceState& state) {
  if (state.history.size() < InterfaceState::kHistory) return std::nullopt;
  const InterfaceSample& last = state.history.front();
  const InterfaceState before{.time = last.time,
                              .motions = last.motions,
                              .wrenches = last.wrenches,
                              .history = {state.history.begin() + 1, state.history.end()}};
  return predict_motions(prediction, before, state.time - last.time);
}

/// Whether a port has been led away from where the past expects it: by more than kFarOut, and by
/// far more than the past was wrong by in the last step.
bool far_out(const MotionSet& expected, const MotionSet& motions, Prediction prediction,
             const InterfaceState& state, const std::vector<PortInfo>& ports) {
  const Eigen::VectorXd away = difference(expected, motions);
  const auto far = [&](Eigen::Index at, double limit) {
    return away.segment<3>(at).norm() > limit;
  };
  std::optional<Eigen::VectorXd> usual;
  for (std::size_t p = 0; p < ports.size(); ++p) {
    const auto at = 12 * static_cast<Eigen::Index>(p);
    const bool moved = far(at, kFarOut * ports[p].length_m), turned = far(at + 3, kFarOut);
    if (!moved && !turned) continue;
    if (!usual) {
      const std::optional<MotionSet> before = predicted_before(prediction, state);
      if (!before) return false;
      usual = difference(*before, state.motions);
    }
    if (moved && far(at, kTimesExpected * usual->segment<3>(at).norm())) return true;
    if (turned && far(at + 3, kTimesExpected * usual->segment<3>(at + 3).norm())) return true;
  }
  return false;
}

}  // namespace

Evaluation joined(const StepResult<MotionSet>& mbs, const StepResult<WrenchSet>& fem,
                  const WrenchSet& lambda, const std::vector<PortInfo>& ports) {
  Evaluation evaluation;
  evaluation.outcome = Outcome::Done;
  const bool mbs_done = take_outcome(mbs, evaluation);
  const bool fem_done = take_outcome(fem, evaluation);
  if (!mbs_done || !fem_done) return evaluation;
  evaluation.motions = mbs.output;
  evaluation.wrenches = fem.output;
  evaluation.residual = stack(fem.output) - stack(lambda);
  evaluation.residual_N = wrench_norm_N(unstack_wrenches(evaluation.residual), ports);
  evaluation.own = fem.own;
  evaluation.wrench_N = wrench_norm_N(fem.own.empty() ? fem.output : fem.own, ports);
  evaluation.output_error_N = fem.output_error_N;
  return evaluation;
}

namespace {

/// The flexible side's answer to the motions `seen`, joined with that of the multibody side.
Evaluation answered(SimTime H, const InterfaceState& state, const WrenchSet& lambda,
                    Linearize linearize, const StepResult<MotionSet>& m, MotionSet seen,
                    FemSide& fem, const std::vector<PortInfo>& ports) {
  const auto l =
      fem.advance({.step = H, .input = {state.motions, seen}, .linearize = linearize.fem});
  Evaluation evaluation = joined(m, l, lambda, ports);
  if (evaluation.outcome == Outcome::Failed) return evaluation;
  evaluation.seen = std::move(seen);
  if (linearize.mbs) evaluation.mbs_jacobian = take_jacobian("mbs", m);
  if (linearize.fem) evaluation.fem_jacobian = take_jacobian("fem", l);
  return evaluation;
}

}  // namespace

Evaluation evaluate(SimTime H, const InterfaceState& state, const WrenchSet& lambda,
                    Linearize linearize, MbsSide& mbs, FemSide& fem,
                    const std::vector<PortInfo>& ports) {
  const auto m =
      mbs.advance({.step = H, .input = {state.wrenches, lambda}, .linearize = linearize.mbs});
  if (m.outcome == Outcome::Failed) return {.outcome = m.outcome, .message = m.message};
  return answered(H, state, lambda, linearize, m, m.output, fem, ports);
}

Evaluation evaluate_first(SimTime H, const InterfaceState& state, const WrenchSet& lambda,
                          Prediction motions, Linearize linearize, MbsSide& mbs, FemSide& fem,
                          const std::vector<PortInfo>& ports) {
  const auto m =
      mbs.advance({.step = H, .input = {state.wrenches, lambda}, .linearize = linearize.mbs});
  if (m.outcome == Outcome::Failed) return {.outcome = m.outcome, .message = m.message};
  MotionSet expected = predict_motions(motions, state, H);
  const bool apart = far_out(expected, m.output, motions, state, ports);
  Evaluation evaluation =
      answered(H, state, lambda, linearize, m, apart ? std::move(expected) : m.output, fem, ports);
  evaluation.apart = apart;
  return evaluation;
}

bool led_astray(SimTime H, const MotionSet& expected, const MotionSet& motions) {
  constexpr double kAstray_rad = 1.0;
  for (std::size_t p = 0; p < motions.size(); ++p) {
    // Written so that a motion that is no number is.
    const double turn_rad = to_seconds(H) * (motions[p].w_WP - expected[p].w_WP).norm();
    if (!(turn_rad <= kAstray_rad)) return true;
  }
  return false;
}

Eigen::VectorXd newton_residual(const Evaluation& evaluation, const InterfaceJacobian& fem) {
  if (!evaluation.apart) return evaluation.residual;
  return evaluation.residual + fem * difference(evaluation.seen, evaluation.motions);
}

Evaluation evaluate_parallel(SimTime H, const InterfaceState& state, const WrenchSet& lambda,
                             const MotionSet& motions, MbsSide& mbs, FemSide& fem,
                             const std::vector<PortInfo>& ports) {
  fem.begin_advance({.step = H, .input = {state.motions, motions}});
  mbs.begin_advance({.step = H, .input = {state.wrenches, lambda}});
  // Both answers are taken before either is judged: a begun advance must be finished.
  const auto m = mbs.finish_advance();
  const auto l = fem.finish_advance();
  return joined(m, l, lambda, ports);
}

void roll_back(MbsSide& mbs, FemSide& fem) {
  mbs.rollback();
  fem.rollback();
}

double residual_limit_N(const CouplingParams& params, const Evaluation& evaluation,
                        double largest_N) {
  return params.tolerance_N + params.relative_tolerance * std::max(evaluation.wrench_N, largest_N);
}

MacroStepEnd end_of(const Evaluation& evaluation, const WrenchSet& applied,
                    std::int32_t iterations) {
  return {.outcome = evaluation.outcome,
          .message = evaluation.message,
          .motions = evaluation.motions,
          .wrenches = evaluation.wrenches,
          .own = evaluation.own,
          .applied = applied,
          .iterations = iterations,
          .residual_N = evaluation.residual_N};
}

double wrench_round_off_N(const MotionSet& motions, const InterfaceJacobian& fem,
                          const std::vector<PortInfo>& ports) {
  Eigen::VectorXd rounded(12 * static_cast<Eigen::Index>(ports.size()));
  for (std::size_t p = 0; p < ports.size(); ++p) {
    const Motion& m = motions[p];
    rounded.segment<12>(12 * static_cast<Eigen::Index>(p))
        << m.p_WP.cwiseAbs().array() + ports[p].length_m,
        Eigen::Vector3d::Ones(), m.v_WP.cwiseAbs(), m.w_WP.cwiseAbs();
  }
  rounded *= 4.0 * std::numeric_limits<double>::epsilon();
  return wrench_norm_N(unstack_wrenches(fem.cwiseAbs() * rounded), ports);
}

double pose_round_off_N(SimTime H, const MotionSet& motions, const InterfaceJacobian& fem,
                        const std::vector<PortInfo>& ports) {
  Eigen::VectorXd rounded(12 * static_cast<Eigen::Index>(ports.size()));
  for (std::size_t p = 0; p < ports.size(); ++p) {
    rounded.segment<12>(12 * static_cast<Eigen::Index>(p)) << Eigen::Vector3d::Zero(),
        Eigen::Vector3d::Zero(), motions[p].p_WP.cwiseAbs().array() + ports[p].length_m,
        Eigen::Vector3d::Ones();
  }
  rounded *= 4.0 * std::numeric_limits<double>::epsilon() / to_seconds(H);
  return wrench_norm_N(unstack_wrenches(fem.cwiseAbs() * rounded), ports);
}

bool looks_like_round_off(double residual_N, double round_off_N) {
  return residual_N <= 1e3 * round_off_N;
}

std::optional<std::string> solver_remedy(double residual_N, double round_off_N, double solver_N) {
  if (solver_N <= round_off_N || !looks_like_round_off(residual_N, solver_N)) return std::nullopt;
  return fmt::format(
      "The flexible side's own solver leaves up to {:.3g} N in the wrench: lower "
      "fem.solver.tolerance, or raise coupling.relative_tolerance (left out, both follow from "
      "run.accuracy).",
      solver_N);
}

}  // namespace tandem
