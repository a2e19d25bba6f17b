#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "fem_process/body/integrator.h"
#include "protocol/contract/segment.h"
#include "protocol/contract/subsystem.h"

namespace tandem::fem {

/// What n micro steps answer together: the mean of their wrenches where reactions act constantly
/// over each, λ = (1/n) Σ λ_j, so that H λ is the impulse which the ports have passed on; else the
/// last. Jacobians alike. n = 1 gives the only one, bit for bit.
class MacroStepWrench {
 public:
  MacroStepWrench(const Integrator& integrator, std::int64_t micro_steps)
      : mean_(integrator.constant_forces()), micro_steps_(micro_steps) {}

  void add(const WrenchSet& wrenches) { take(stack(wrenches), wrench_); }
  void add(const InterfaceJacobian& jacobian) { take(jacobian, jacobian_); }

  [[nodiscard]] WrenchSet wrenches() const { return unstack_wrenches(wrench_ / divisor()); }
  [[nodiscard]] InterfaceJacobian jacobian() const { return jacobian_ / divisor(); }

 private:
  template <class Value>
  void take(const Value& value, Value& taken) const {
    if (mean_ && taken.size() > 0) {
      taken += value;
    } else {
      taken = value;
    }
  }
  [[nodiscard]] double divisor() const { return mean_ ? static_cast<double>(micro_steps_) : 1.0; }

  bool mean_;
  std::int64_t micro_steps_;
  Eigen::VectorXd wrench_;
  InterfaceJacobian jacobian_;
};

/// How the velocities of port motions are interpolated for the micro steps of an integrator.
[[nodiscard]] inline VelocityRule velocity_rule(const Integrator& integrator) {
  return integrator.constant_forces() ? VelocityRule::Linear : VelocityRule::Derivative;
}

}  // namespace tandem::fem
