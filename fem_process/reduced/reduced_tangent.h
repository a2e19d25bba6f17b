#pragma once

#include <vector>

#include "fem_process/reduced/reduced_step.h"
#include "fem_process/transient/step_tangent.h"

namespace tandem::fem {

/// Exact derivative of the wrenches after each micro step with respect to the motions at its end:
/// carries the derivatives of the reduced state through the micro steps.
class ReducedTangent {
 public:
  /// At the start of a macro step the state does not depend on its input. The reference is kept.
  explicit ReducedTangent(const ReducedModel& reduced) : reduced_(reduced) {}

  /// Carries the derivatives through the micro step from `before` that `result` came from;
  /// `motions` derives its end from the macro step's.
  void advance(const ReducedState& before, const MotionDerivative& motions,
               const ReducedStep::Result& result);

  /// 6P × 12P, of the wrenches after the last micro step.
  [[nodiscard]] const InterfaceJacobian& jacobian() const { return jacobian_; }

 private:
  /// What changes with one coordinate of one port's end motion.
  struct Direction {
    ReducedState begin;              ///< derivative of the state before the step; empty: zero
    FloatingFrame::Change at_begin;  ///< of the placement there
    FloatingFrame::Change at_end;
    StepMap modal_map, field_map;  ///< derivatives of the affine maps
    ReducedTurn turn;              ///< of what the fields start from
    Eigen::VectorXd eta_hat;
    FieldMotion Y, V;
  };
  void place(const ReducedState& before, const MotionDerivative& motions,
             const ReducedStep::Result& result, Eigen::Index column, Direction& direction) const;
  void finish(const ReducedStep::Result& result, FieldMotion inertia, const FieldMotion& momentum,
              const Eigen::VectorXd& eta_dot, Eigen::Index column, Direction& direction);

  const ReducedModel& reduced_;
  std::vector<Direction> directions_;
  InterfaceJacobian jacobian_;
};

}  // namespace tandem::fem
