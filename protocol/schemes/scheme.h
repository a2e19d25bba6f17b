#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/schemes/accelerator.h"
#include "protocol/schemes/body_blocks.h"
#include "protocol/schemes/coupling_params.h"
#include "protocol/schemes/jacobian_block.h"
#include "protocol/schemes/macro_step.h"
#include "protocol/schemes/prediction.h"
#include "protocol/schemes/residual_floor.h"
#include "protocol/schemes/retained_inertia.h"

namespace tandem {

/// The rule by which a macro step is made. Written once against the two sides' contract: whether a
/// side is a local object, a process behind LCM, a log or a mock does not show here.
/// Both sides are at t_n and checkpointed on entry, and at t_n + H on return (unless Failed).
class Scheme {
 public:
  virtual ~Scheme() = default;
  virtual MacroStepEnd advance(SimTime H, const InterfaceState& state, MbsSide& mbs,
                               FemSide& fem) = 0;
};

/// m ← M(λ predicted), λ ← Λ(m): one evaluation, no iteration.
/// Error of the applied wrench is O(H) (hold), O(H²) (linear) or O(H³) (quadratic). Unstable once
/// the effective mass of the flexible side at a port exceeds that of the rigid side.
class ExplicitSerial final : public Scheme {
 public:
  ExplicitSerial(const CouplingParams& params, std::vector<PortInfo> ports);
  MacroStepEnd advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) override;

 private:
  CouplingParams params_;
  std::vector<PortInfo> ports_;
  RetainedInertia inertia_;
};

/// m ← M(λ predicted) and λ ← Λ(m predicted): both sides compute at the same time, each from what
/// the accepted past says of the other.
class ExplicitParallel final : public Scheme {
 public:
  ExplicitParallel(const CouplingParams& params, std::vector<PortInfo> ports);
  MacroStepEnd advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) override;

 private:
  CouplingParams params_;
  std::vector<PortInfo> ports_;
  RetainedInertia inertia_;
};

/// Fixed-point iteration with rollback, accelerated by relaxation or a quasi-Newton method.
///   serial (block Gauss–Seidel):  x = λ,       G(x) = Λ(M(λ));
///   parallel (block Jacobi):      x = (m, λ),  G(x) = (M(λ), Λ(m)), both sides at the same time.
/// Converged when ‖Λ − λ‖ is within the tolerance and, in parallel, ‖M − m‖ too: the latter by the
/// velocities, in m/s, within relative_tolerance ‖M‖ (or ‖m_n‖) and what the tolerance of the
/// wrench makes of them by the largest ‖ΔM‖/‖Δλ‖ seen.
class Implicit final : public Scheme {
 public:
  Implicit(const CouplingParams& params, std::vector<PortInfo> ports);
  MacroStepEnd advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) override;

 private:
  MacroStepEnd in_turn(SimTime H, const InterfaceState& state, bool accepted, MbsSide& mbs,
                       FemSide& fem);
  MacroStepEnd in_parallel(SimTime H, const InterfaceState& state, bool accepted, MbsSide& mbs,
                           FemSide& fem);

  CouplingParams params_;
  std::vector<PortInfo> ports_;
  std::unique_ptr<Accelerator> accelerator_;
  std::optional<SimTime> begun_;  ///< beginning of the last macro step
  ResidualFloor floor_;
  double admittance_per_kg_ = 0.0;  ///< of the multibody side at the ports, largest seen
};

/// Newton's method on r(λ) = Λ(M(λ)) − λ with both sides' interface Jacobians:
///   (I − L B) δλ = r,   B = ∂M/∂λ (12P × 6P),   L = ∂Λ/∂m (6P × 12P),
/// linearised once per macro step at the predicted wrench and kept (chord iteration): where both
/// sides are affine in the port quantities two evaluations suffice. Either block may be kept for
/// longer (JacobianBlock), at the price of further iterations; after every four evaluations, unless
/// the last one has lowered the residual to a tenth, both are taken anew at the present iterate.
/// [Sicklinger et al. 2014, Interface Jacobian-based co-simulation algorithm]
class InterfaceJacobianScheme final : public Scheme {
 public:
  InterfaceJacobianScheme(const CouplingParams& params, std::vector<PortInfo> ports);
  MacroStepEnd advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) override;

 private:
  CouplingParams params_;
  std::vector<PortInfo> ports_;
  JacobianBlock mbs_block_;
  BodyBlocks fem_blocks_;
  ResidualFloor floor_;
};

[[nodiscard]] std::unique_ptr<Scheme> make_scheme(const CouplingParams& params,
                                                  std::vector<PortInfo> ports);

}  // namespace tandem
