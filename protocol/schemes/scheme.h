#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/schemes/coupling_params.h"

namespace tandem {

/// What is known at the beginning of a macro step: the accepted interface at t_n.
struct InterfaceState {
  SimTime time{};
  MotionSet motions;            ///< m_n
  WrenchSet wrenches;           ///< λ_n
  WrenchSet previous_wrenches;  ///< λ_{n−1}; empty in the first macro step
};

/// λ at t_n + H extrapolated from accepted wrenches: hold λ_n, or linear 2 λ_n − λ_{n−1} (λ_n in
/// the first macro step).
[[nodiscard]] WrenchSet predict(Prediction prediction, const InterfaceState& state);

/// How one macro step ended.
struct MacroStepEnd {
  Outcome outcome = Outcome::Failed;
  std::string message = "the macro step was not made";
  MotionSet motions;   ///< at t_n + H
  WrenchSet wrenches;  ///< at t_n + H, as the flexible side answered
  WrenchSet applied;   ///< the λ that moved the multibody side
  std::int32_t iterations = 0;
  double residual_N = 0.0;  ///< ‖Λ(M(λ)) − λ‖ of the last iteration
};

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
/// Error of the applied wrench is O(H) (hold) or O(H²) (linear). Unstable once the effective mass
/// of the flexible side at a port exceeds that of the rigid side.
class ExplicitSerial final : public Scheme {
 public:
  ExplicitSerial(const CouplingParams& params, std::vector<PortInfo> ports);
  MacroStepEnd advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) override;

 private:
  CouplingParams params_;
  std::vector<PortInfo> ports_;
};

/// Fixed-point iteration λ ← λ + ω (Λ(M(λ)) − λ) with rollback (block Gauss–Seidel).
/// ω constant, or Aitken's Δ² factor ω ← −ω r_old·(r − r_old)/‖r − r_old‖² in the scaled norm
/// [Irons & Tuck 1969; Küttler & Wall 2008, eq. 44].
class Implicit final : public Scheme {
 public:
  Implicit(const CouplingParams& params, std::vector<PortInfo> ports);
  MacroStepEnd advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) override;

 private:
  CouplingParams params_;
  std::vector<PortInfo> ports_;
};

/// Newton's method on r(λ) = Λ(M(λ)) − λ with both sides' interface Jacobians:
///   (I − L B) δλ = r,   B = ∂M/∂λ (12P × 6P),   L = ∂Λ/∂m (6P × 12P),
/// linearised once per macro step at the predicted wrench and kept (chord iteration): where both
/// sides are affine in the port quantities two evaluations suffice. [Sicklinger et al. 2014,
/// Interface Jacobian-based co-simulation algorithm]
class InterfaceJacobianScheme final : public Scheme {
 public:
  InterfaceJacobianScheme(const CouplingParams& params, std::vector<PortInfo> ports);
  MacroStepEnd advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) override;

 private:
  CouplingParams params_;
  std::vector<PortInfo> ports_;
};

[[nodiscard]] std::unique_ptr<Scheme> make_scheme(const CouplingParams& params,
                                                  std::vector<PortInfo> ports);

}  // namespace tandem
