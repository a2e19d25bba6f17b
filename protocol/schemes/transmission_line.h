#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/schemes/jacobian_block.h"
#include "protocol/schemes/port_impedance.h"
#include "protocol/schemes/scheme.h"

namespace tandem {

/// Characteristic impedance of the lines, one per component of the stacked twists:
///   Z = k H for velocities (N s/m), Z = k L² H for angular velocities (N m s),
/// k the line's stiffness, H its delay, L the port's length.
[[nodiscard]] Eigen::VectorXd line_impedance(double stiffness_N_per_m, SimTime delay,
                                             const std::vector<PortInfo>& ports);

/// Transmission-line coupling: a lossless elastic line joins the rigid side's port (1) and the
/// flexible side's (2). Its delay is the macro step, so each end knows the wave that comes in,
///   λ1⁺ = a1 − Z V1⁺,   a1 = λ2 + Z V2 at t_n,
///   λ2⁺ = a2 + Z V2⁺,   a2 = λ1 − Z V1 at t_n,
/// and both sides compute at the same time, with one exchange a step. Each end is an implicit
/// damper with an incoming wave: energy is only delayed in the line, whatever masses and
/// stiffnesses it joins, so the coupling is unconditionally stable. The price is physical: the line
/// has the compliance 1/k and the mass m = Z H = k H². [Auslander 1968; Krus et al. 1990]
///
/// In a macro step an end takes λ1 V1 H = (a1² − (λ1 − Z V1)²) H/(4 Z) from the line, so what the
/// waves carry is (a1² + a2²)/(4 k) whatever H: waves that left in a step of one length arrive in a
/// step of another with their energy, and the line stays lossless with adaptive steps.
///
/// λ2 and V1 are what the sides exchange anyway. From λ2⁺ = a2 + Z V2⁺ the scheme knows Z V2
/// without being told; LineEnd is the flexible side's end.
class TransmissionLine final : public Scheme {
 public:
  TransmissionLine(const CouplingParams& params, std::vector<PortInfo> ports);
  MacroStepEnd advance(SimTime H, const InterfaceState& state, MbsSide& mbs, FemSide& fem) override;

 private:
  double stiffness_N_per_m_;
  std::vector<PortInfo> ports_;
  PortImpedance rigid_end_;
  /// Of an accepted macro step: the impedance, λ1 at its end, and the wave a2 that left at its
  /// beginning.
  struct Line {
    Eigen::VectorXd Z, lambda1, a2;
  };
  std::optional<Line> line_;
  std::optional<Line> pending_;
  std::optional<SimTime> begun_;
};

/// The flexible side behind its end of the lines: takes the rigid side's motions at the beginning
/// of the macro step, moves its own port frames so that λ2⁺ = a2 + Z V2⁺ holds, and answers λ2⁺.
/// The port frames move by p⁺ = p + H v⁺, R⁺ = exp(H w⁺ ×) R; Newton's method with the side's
/// interface Jacobian, no exchange.
class LineEnd final : public FemSide {
 public:
  LineEnd(std::unique_ptr<FemSide> inner, double stiffness_N_per_m);
  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  WrenchSet initialize(const MotionSet& motions) override;
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override;
  void checkpoint() override;
  void rollback() override;
  Observation observe() override;
  CommandResult command(const std::string& text) override { return inner_->command(text); }

 private:
  struct State {
    MotionSet motions;            ///< of the line's end 2
    Eigen::VectorXd lambda2;      ///< answered last
    Eigen::VectorXd Z;            ///< of the last macro step; empty before the first
    Eigen::VectorXd a1, a1_next;  ///< waves that left for the rigid side at t_{n−1} and t_n
    JacobianBlock block{Refresh::Broyden, 1};
  };
  StepResult<WrenchSet> solve(const StepRequest<MotionSet>& request, const Eigen::VectorXd& a2,
                              MotionSet& motions);
  [[nodiscard]] MotionSet moved(const MotionSet& from, const Eigen::VectorXd& V, double H_s) const;

  std::unique_ptr<FemSide> inner_;
  SubsystemInfo info_;
  double stiffness_N_per_m_;
  State state_, saved_;
};

/// `side` as the scheme of `params` needs it: behind a LineEnd for tlm, else as it is.
[[nodiscard]] std::unique_ptr<FemSide> prepared_for(const CouplingParams& params,
                                                    std::unique_ptr<FemSide> side);

}  // namespace tandem
