#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/scheme.h"

namespace tandem {

ExplicitSerial::ExplicitSerial(const CouplingParams& params, std::vector<PortInfo> ports)
    : params_(params), ports_(std::move(ports)) {}

MacroStepEnd ExplicitSerial::advance(SimTime H, const InterfaceState& state, MbsSide& mbs,
                                     FemSide& fem) {
  const WrenchSet lambda = predict(params_.prediction, state);
  const Evaluation evaluation = evaluate(H, state, lambda, false, mbs, fem, ports_);
  return end_of(evaluation, lambda, 1);
}

}  // namespace tandem
