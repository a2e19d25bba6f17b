#include "protocol/schemes/scheme.h"

#include <stdexcept>

#include "protocol/schemes/transmission_line.h"

namespace tandem {

std::unique_ptr<Scheme> make_scheme(const CouplingParams& params, std::vector<PortInfo> ports) {
  switch (params.scheme) {
    case SchemeKind::ExplicitSerial:
      return std::make_unique<ExplicitSerial>(params, std::move(ports));
    case SchemeKind::ExplicitParallel:
      return std::make_unique<ExplicitParallel>(params, std::move(ports));
    case SchemeKind::Implicit:
      return std::make_unique<Implicit>(params, std::move(ports));
    case SchemeKind::Tlm:
      return std::make_unique<TransmissionLine>(params, std::move(ports));
    case SchemeKind::InterfaceNewton:
      return std::make_unique<InterfaceJacobianScheme>(params, std::move(ports));
  }
  throw std::logic_error("scheme kind without a scheme");
}

}  // namespace tandem
