#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/schemes/coupling_params.h"
#include "protocol/schemes/jacobian_block.h"
#include "protocol/schemes/prediction.h"

namespace tandem {

/// How the multibody side ended a step under an impedance.
struct ImpedanceEnd {
  StepResult<MotionSet> result;
  WrenchSet applied;             ///< the λ that solves the equation
  std::int32_t evaluations = 0;  ///< of the multibody side
};

/// The multibody side with an impedance Z at its ports: makes a macro step under the wrench
///   λ = a − Z V(λ),   V the port twists at the end of the step,
/// which is what a damper, a mass (Z = m/H) or a transmission line at the ports exerts. Newton's
/// method with B = ∂M/∂λ, kept from step to step with Broyden's updates; the side is rolled back
/// between evaluations. No exchange with the flexible side is needed, so that Z costs evaluations
/// of the multibody side alone: two where it is affine in λ.
class PortImpedance {
 public:
  explicit PortImpedance(std::vector<PortInfo> ports)
      : ports_(std::move(ports)), block_(Refresh::Broyden, 1) {}

  /// The multibody side must be at the beginning of the step. NotConverged when the equation is not
  /// solved to 1e-12 of its terms.
  [[nodiscard]] ImpedanceEnd advance(SimTime H, const WrenchSet& begin, const Eigen::VectorXd& a,
                                     const Eigen::MatrixXd& Z, const WrenchSet& guess,
                                     MbsSide& mbs);

 private:
  std::vector<PortInfo> ports_;
  JacobianBlock block_;
};

}  // namespace tandem
