#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/schemes/coupling_params.h"
#include "protocol/schemes/macro_step.h"
#include "protocol/schemes/port_impedance.h"
#include "protocol/schemes/prediction.h"

namespace tandem {

/// Lets the rigid side of an explicit scheme carry the flexible side's effective port inertia M̂ and
/// subtracts the inertia force that the predicted wrench has booked already:
///   λ = λ̂ − M̂ (V⁺ − V_n)/H + M̂ α̂,
/// α̂ the port acceleration that is booked in λ̂, extrapolated like it. With M̂ = the true one μ the
/// inertia acts at once instead of a step later; with M̂ ≠ μ an error of the wrench returns times
/// (M̂ − μ)/(m + M̂), so the scheme is stable for μ < m + 2 M̂ instead of μ < m.
/// [after Morandini & Masarati 2026]
/// M̂ is what the flexible side's interface Jacobian says, −H (∂Λ/∂V + H ∂Λ/∂(p, θ)), all ports
/// together, kept in the axes of the ports.
class RetainedInertia {
 public:
  RetainedInertia(const CouplingParams& params, std::vector<PortInfo> ports)
      : params_(params), ports_(ports), rigid_side_(std::move(ports)) {}

  [[nodiscard]] bool active() const { return params_.retained_inertia.factor > 0.0; }

  /// One explicit macro step with the predicted wrench λ̂. The flexible side is given `motions`, at
  /// the same time as the multibody side computes; with none, the multibody side's answer. A macro
  /// step in which M̂ is taken, the first one at least, evaluates both sides once more.
  MacroStepEnd advance(SimTime H, const InterfaceState& state, const WrenchSet& predicted,
                       const MotionSet* motions, MbsSide& mbs, FemSide& fem);

 private:
  /// The wrench's equation λ = a − Z V⁺.
  struct Equation {
    Eigen::VectorXd a;
    Eigen::MatrixXd Z;
  };
  /// True when M̂ is to be taken anew.
  [[nodiscard]] bool begin_step(SimTime H, const InterfaceState& state);
  void take(const InterfaceJacobian& fem, SimTime H, const MotionSet& motions);
  [[nodiscard]] Equation equation(const InterfaceState& state, SimTime H,
                                  const WrenchSet& predicted) const;
  /// The motion that the flexible side was given for the end of this macro step.
  void book(SimTime H, const MotionSet& given);

  CouplingParams params_;
  std::vector<PortInfo> ports_;
  PortImpedance rigid_side_;
  SimTime step_{};
  std::int32_t age_ = 0;       ///< accepted macro steps since M̂ was taken
  Eigen::MatrixXd inertia_P_;  ///< M̂, 6P × 6P, axes of the ports (kg, kg m, kg m²)
  /// What the flexible side was given last, and the accelerations that its wrenches at t_n,
  /// t_{n−1}, t_{n−2} have booked.
  struct Booked {
    Eigen::VectorXd given;
    std::vector<Eigen::VectorXd> accelerations;
  };
  Booked booked_;
  std::optional<Booked> pending_;  ///< of the last macro step, if it is accepted
  std::optional<SimTime> begun_;
};

}  // namespace tandem
