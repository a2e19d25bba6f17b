#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/scheme.h"

namespace tandem {

ExplicitSerial::ExplicitSerial(const CouplingParams& params, std::vector<PortInfo> ports)
    : params_(params), ports_(std::move(ports)), inertia_(params_, ports_) {}

MacroStepEnd ExplicitSerial::advance(SimTime H, const InterfaceState& state, MbsSide& mbs,
                                     FemSide& fem) {
  const WrenchSet lambda = predict_wrenches(params_.prediction, state, H);
  if (inertia_.active()) {
    return inertia_.advance(H, state, lambda, nullptr, mbs, fem);
  }
  return end_of(evaluate(H, state, lambda, {}, mbs, fem, ports_), lambda, 1);
}

}  // namespace tandem
