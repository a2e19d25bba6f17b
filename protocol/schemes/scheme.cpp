#include "protocol/schemes/scheme.h"

#include <stdexcept>

namespace tandem {

WrenchSet predict(Prediction prediction, const InterfaceState& state) {
  if (prediction == Prediction::Hold || state.previous_wrenches.empty()) return state.wrenches;
  return unstack_wrenches(2.0 * stack(state.wrenches) - stack(state.previous_wrenches));
}

std::unique_ptr<Scheme> make_scheme(const CouplingParams& params, std::vector<PortInfo> ports) {
  switch (params.scheme) {
    case SchemeKind::ExplicitSerial:
      return std::make_unique<ExplicitSerial>(params, std::move(ports));
    case SchemeKind::Implicit:
      return std::make_unique<Implicit>(params, std::move(ports));
    case SchemeKind::InterfaceNewton:
      return std::make_unique<InterfaceJacobianScheme>(params, std::move(ports));
  }
  throw std::logic_error("scheme kind without a scheme");
}

}  // namespace tandem
