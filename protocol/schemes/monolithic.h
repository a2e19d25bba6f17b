#pragma once

#include <vector>

#include "protocol/schemes/residual_floor.h"
#include "protocol/schemes/scheme.h"

namespace tandem {

/// The monolithic step: one coupled system per macro step, solved directly and iterated to
/// round-off.
///
/// The flexible interior is eliminated exactly onto the ports (Schur complement of the step
/// matrix), λ = Λ̂ + L δm; the multibody system is represented by its own exact response at the
/// ports, m = m̂ + B δλ (ODE's step is affine in the port wrench while no limit or contact
/// switches). Together
///   [  I  −B ] [δm]   [  0 ]
///   [ −L   I ] [δλ] = [  r ],     r = Λ(M(λ)) − λ,
/// is solved by LU for the 18 unknowns of each port, and the remaining nonlinearity (finite
/// rotation of the ports within the step) is iterated, with new derivatives where the old ones are
/// slow, until the residual no longer falls: there is no tolerance to choose. This is the direct
/// integration of [MZ12], the reference for cost and for coupling error. Both sides must be objects
/// of this process; one that cannot linearise is a Usage error.
class MonolithicStep final : public Scheme {
 public:
  explicit MonolithicStep(std::vector<PortInfo> ports) : ports_(std::move(ports)) {}
  MacroStepEnd advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) override;

 private:
  static constexpr std::int32_t kPatience = 3;
  std::vector<PortInfo> ports_;
  ResidualFloor floor_{kPatience, 0.0};
};

}  // namespace tandem
