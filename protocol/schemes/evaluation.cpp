#include "protocol/schemes/evaluation.h"

#include <algorithm>

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
          std::string("coupling.scheme: interface_jacobian needs the interface Jacobian of the ") +
              side + " side, which has none. Use implicit or explicit_serial.");
  return *result.jacobian;
}

}  // namespace

Evaluation evaluate(SimTime H, const InterfaceState& state, const WrenchSet& lambda, bool linearize,
                    MbsSide& mbs, FemSide& fem, const std::vector<PortInfo>& ports) {
  Evaluation evaluation;
  evaluation.outcome = Outcome::Done;
  auto m = mbs.advance({.step = H, .input = {state.wrenches, lambda}, .linearize = linearize});
  if (!take_outcome(m, evaluation)) return evaluation;
  auto l = fem.advance({.step = H, .input = {state.motions, m.output}, .linearize = linearize});
  if (!take_outcome(l, evaluation)) return evaluation;

  evaluation.residual = stack(l.output) - stack(lambda);
  evaluation.residual_N = wrench_norm_N(unstack_wrenches(evaluation.residual), ports);
  evaluation.wrench_N = wrench_norm_N(l.output, ports);
  if (linearize) {
    evaluation.mbs_jacobian = take_jacobian("mbs", m);
    evaluation.fem_jacobian = take_jacobian("fem", l);
  }
  evaluation.motions = std::move(m.output);
  evaluation.wrenches = std::move(l.output);
  return evaluation;
}

void roll_back(MbsSide& mbs, FemSide& fem) {
  mbs.rollback();
  fem.rollback();
}

double residual_limit_N(const CouplingParams& params, const Evaluation& evaluation) {
  return params.tolerance_N + params.relative_tolerance * evaluation.wrench_N;
}

MacroStepEnd end_of(const Evaluation& evaluation, const WrenchSet& applied,
                    std::int32_t iterations) {
  return {.outcome = evaluation.outcome,
          .message = evaluation.message,
          .motions = evaluation.motions,
          .wrenches = evaluation.wrenches,
          .applied = applied,
          .iterations = iterations,
          .residual_N = evaluation.residual_N};
}

}  // namespace tandem
