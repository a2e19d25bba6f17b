#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/scheme.h"

namespace tandem {

ExplicitParallel::ExplicitParallel(const CouplingParams& params, std::vector<PortInfo> ports)
    : params_(params), ports_(std::move(ports)), inertia_(params_, ports_) {}

MacroStepEnd ExplicitParallel::advance(SimTime H, const InterfaceState& state, MbsSide& mbs,
                                       FemSide& fem) {
  const WrenchSet lambda = predict_wrenches(params_.prediction, state, H);
  const MotionSet motions = predict_motions(params_.motion_prediction, state, H);
  if (inertia_.active()) {
    return inertia_.advance(H, state, lambda, &motions, mbs, fem);
  }
  return end_of(evaluate_parallel(H, state, lambda, motions, mbs, fem, ports_), lambda, 1);
}

}  // namespace tandem
