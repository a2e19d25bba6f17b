#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "fem_process/body/model.h"
#include "fem_process/body/state.h"
#include "fem_process/transient/angular_balance.h"
#include "fem_process/transient/loose_tangent.h"
#include "fem_process/transient/transient_step.h"
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
/// matrix leaves out is in: once for an exact tangent. The kinematics around the
/// balance of forces (how the body is carried, where its ports end, what becomes
/// of the state) cost a few operations per node: their derivatives are central
/// differences along the direction, of which 1e-9 is left.
class StepTangent {
 public:
  /// At the start of a macro step the state does not depend on its input. References are kept.
  StepTangent(const Model& model, const TransientStep& step, std::int64_t micro_steps)
      : model_(model),
        step_(step),
        arms_(step.arms()),
        loose_(step.loose_ports()),
        carry_(step.carry()),
        micro_steps_(micro_steps) {}

  /// Motions of the ports and their derivatives.
  struct Motions {
    MotionSet value;
    MotionDerivative derivative;
  };
  /// Carries the derivatives through the micro step from `begin` that `result` and `kept`
  /// came from; `about` as in TransientStep::advance.
  SolveReport advance(const State& begin, const Motions& end, const MotionSet& about,
                      const TransientStep::Result& result, const Linearisation& kept);

  /// 6P × 12P, of the wrenches after the last micro step.
  [[nodiscard]] const InterfaceJacobian& jacobian() const { return jacobian_; }

 private:
  /// The micro step that derivatives go through.
  struct Step {
    const State& begin;
    const Motions& end;
    const MotionSet& about;
    const TransientStep::Result& result;
    const Linearisation& kept;  ///< the step's first
    const LooseTangent* loose = nullptr;
    [[nodiscard]] const Linearisation& last() const { return kept.last(); }
  };
  /// What changes with one coordinate of one port's end motion.
  struct Direction {
    State begin;                  ///< derivative of the state before the micro step; empty: zero
    Eigen::VectorXd port_begin;   ///< of the ports' motions there, 12 per port as in difference()
    Eigen::VectorXd port_end;     ///< of those at the end of the micro step
    double amount = 1e-4;         ///< of the central differences of kinematics
    StepMap map;                  ///< derivative of the step's affine maps
    Eigen::VectorXd dx;           ///< prescribed nodes: of x⁺
    Eigen::VectorXd dv;           ///< of what is solved for
    Eigen::VectorXd dd;           ///< of x⁺ − x̃
    Eigen::VectorXd da;           ///< of a⁺
    Eigen::VectorXd d_circling;   ///< of Carry::circling; empty: zero
    Eigen::VectorXd d_reference;  ///< of the velocities that damping refers to; empty: undamped
    Eigen::VectorXd d_shift;      ///< of Carry::prescribed_shift; empty: undamped
    Eigen::VectorXd d_drag;       ///< of Carried::drag; empty: zero
    LooseTangent::SeenChange d_seen;  ///< of the port motions as the balance has them
    LoosePorts::Rates d_rates;        ///< of ρ and its rates, see LoosePorts
    Eigen::VectorXd d_phi;            ///< of the forces of averaging ports and bushings
    Eigen::VectorXd turning;          ///< of T f_int(x̃) + K(x̃) y at fixed y = β w + d
    Eigen::VectorXd dd_first;         ///< dd where the forces of a correction stand; empty: zero
    Eigen::VectorXd d_about;      ///< of the points that torques are taken about, 3 per port (m)
    Eigen::VectorXd d_origin;     ///< of the ports' origins from there, as forces have arms (m)
    Eigen::VectorXd d_arms_turn;  ///< of the pose that they turn with, 3 per port (rad)
    bool moves = false;           ///< false: nothing changes in the balance of forces
    [[nodiscard]] bool started() const { return begin.x.size() > 0; }
  };
  /// The kinematics of the step with begin and end changed along a direction, `amount` times; the
  /// beginning is the step's own where it does not change.
  struct Nudged {
    const State& begin;
    const Carried& carried;
    MotionSet end;
    std::unique_ptr<const State> own_begin;
    std::unique_ptr<const Carried> own_carried;
  };
  [[nodiscard]] Nudged nudge(const Step& step, const Direction& direction, double amount) const;
  void see(const Step& step, Direction& direction) const;
  [[nodiscard]] Eigen::VectorXd arms_change(const Step& step, const Direction& direction,
                                            const Eigen::VectorXd& dx) const;
  void see_loose(const Nudged& below, const Nudged& above, Direction& direction) const;
  void turn_forces(const Step& step, const Nudged& below, const Nudged& above,
                   Direction& direction) const;
  void prescribe(const Step& step, Eigen::Index column, Direction& direction) const;
  [[nodiscard]] Eigen::VectorXd damped_change(const Direction& direction) const;
  [[nodiscard]] Eigen::VectorXd strained(const Direction& direction) const;
  [[nodiscard]] Eigen::VectorXd moved(const Direction& direction) const;
  [[nodiscard]] const Linearisation& linearised(const Step& step, const Direction& direction) const;
  [[nodiscard]] Eigen::VectorXd residual(const Step& step, const Direction& direction,
                                         ProductPart part, Eigen::VectorXd elastic = {}) const;
  [[nodiscard]] Eigen::MatrixXd residuals(const Step& step,
                                          const std::vector<Eigen::Index>& moving) const;
  SolveReport solve(const Step& step, const std::vector<Eigen::Index>& moving);
  SolveReport correct_once(const Step& step, const std::vector<Eigen::Index>& moving);
  void take(const Step& step, const Eigen::VectorXd& column, Direction& direction) const;
  void attach(const Step& step, Direction& direction) const;
  void answer(const Step& step, Eigen::Index column, const AngularBalance* angular,
              Direction& direction);
  void add_arms(const Step& step, const Direction& direction, WrenchSet& d_wrenches) const;
  [[nodiscard]] State concluded(const Step& step, const Direction& direction) const;
  [[nodiscard]] Eigen::VectorXd drag_change(const Direction& direction) const;
  [[nodiscard]] Eigen::VectorXd damping_change(const Step& step, const Direction& direction) const;

  const Model& model_;
  const TransientStep& step_;
  const PortArms& arms_;
  const LoosePorts& loose_;
  const Carry& carry_;
  std::vector<Direction> directions_;
  InterfaceJacobian jacobian_;
  std::int64_t micro_steps_;
};

}  // namespace tandem::fem
