#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "fem_process/loose_tangent.h"
#include "fem_process/model.h"
#include "fem_process/state.h"
#include "fem_process/transient_step.h"
#include "protocol/contract/segment.h"
#include "protocol/contract/subsystem.h"

namespace tandem::fem {

/// Derivative of an interpolated port motion with respect to the motion at the
/// segment's end, in the local coordinates of difference(), one 12 × 12 block
/// per port.
using MotionDerivative = std::vector<Eigen::Matrix<double, 12, 12>>;
[[nodiscard]] MotionDerivative interpolation_derivative(const Segment<MotionSet>& input, double s,
                                                        SimTime H, VelocityRule rule);

/// Exact derivative of the wrenches after each micro step with respect to the
/// motions at its end: carries the derivatives of the whole state through the
/// micro steps. Every direction costs one solve with the micro step's
/// factorisation; from the second micro step on also the directional derivative
/// of the internal forces, since the linearisation points then depend on the
/// input. Where the step is iterated to equilibrium the derivative is that of
/// the equilibrium, and the solves are repeated until the part that the step
/// matrix leaves out is in: once for an exact tangent.
class StepTangent {
 public:
  /// At the start of a macro step the state does not depend on its input. References are kept.
  StepTangent(const Model& model, const PortArms& arms, const LoosePorts& loose,
              std::int64_t micro_steps)
      : model_(model), arms_(arms), loose_(loose), micro_steps_(micro_steps) {}

  /// Motions of the ports and their derivatives.
  struct Motions {
    MotionSet value;
    MotionDerivative derivative;
  };
  /// Carries the derivatives through the micro step that `result` and `kept`
  /// came from.
  SolveReport advance(const Motions& end, const Motions& torque_pose,
                      const TransientStep::Result& result, const Linearisation& kept);

  /// 6P × 12P, of the wrenches after the last micro step.
  [[nodiscard]] const InterfaceJacobian& jacobian() const { return jacobian_; }

 private:
  /// What changes with one coordinate of one port's end motion.
  struct Direction {
    State begin;                ///< derivative of the state before the micro step; empty: zero
    StepMap map;                ///< derivative of the step's affine maps
    Eigen::VectorXd dx;         ///< prescribed nodes: of x⁺
    Eigen::VectorXd dv;         ///< of v⁺
    Eigen::VectorXd dd;         ///< of x⁺ − x̃
    Eigen::VectorXd da;         ///< of a⁺
    LoosePorts::Rates d_rigid;  ///< of ρ and its rates, see LoosePorts
    Eigen::VectorXd d_phi;      ///< of the forces of averaging ports and bushings
    Eigen::VectorXd turning;    ///< of f_int(x̃) + K(x̃) y at fixed y = β v⁺ + d
    bool moves = false;         ///< false: nothing changes
  };
  void prescribe(const Motions& end, const TransientStep::Result& result, const Linearisation& kept,
                 Eigen::Index column, Direction& direction) const;
  void prescribe_loose(const Motions& end, const Linearisation& kept, const LooseTangent& loose,
                       Eigen::Index column, Direction& direction) const;
  [[nodiscard]] static LooseTangent::Change change_of(const Motions& motions, Eigen::Index column);
  [[nodiscard]] Eigen::VectorXd force(const Direction& direction,
                                      const TransientStep::Result& result,
                                      const Linearisation& kept, ProductPart part) const;
  [[nodiscard]] Eigen::VectorXd residual(const Direction& direction, const Eigen::VectorXd& force,
                                         const Linearisation& kept, ProductPart part) const;
  SolveReport solve(const Motions& end, const std::vector<Eigen::Index>& moving,
                    const TransientStep::Result& result, const Linearisation& kept,
                    const LooseTangent* loose);
  void attach(const LooseTangent::Change& change, const Linearisation& kept,
              const LooseTangent& loose, Direction& direction) const;
  void finish(const Motions& end, const Motions& torque_pose, const TransientStep::Result& result,
              const Linearisation& kept, const LooseTangent* loose, Eigen::Index column,
              Direction& direction);

  const Model& model_;
  const PortArms& arms_;
  const LoosePorts& loose_;
  std::vector<Direction> directions_;
  InterfaceJacobian jacobian_;
  std::int64_t micro_steps_;
};

}  // namespace tandem::fem
