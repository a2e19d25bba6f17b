#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mbs_process/joint_gap.h"
#include "mbs_process/joint_rows.h"
#include "mbs_process/kick.h"
#include "mbs_process/loads.h"
#include "mbs_process/motor_rate.h"
#include "mbs_process/ode_world.h"
#include "mbs_process/params.h"
#include "mbs_process/port_jacobian.h"
#include "mbs_process/state.h"
#include "mbs_process/step_work.h"
#include "mbs_process/wrench_rule.h"
#include "protocol/contract/subsystem.h"

namespace tandem::mbs {

/// The bodies as `params` places and moves them at t = 0.
[[nodiscard]] State initial_state(const Params& params);

/// The multibody side: rigid bodies and joints on ODE, with ports that wrenches act at.
///
/// A port frame P is fixed in its body's frame B:
///   p_WP = p_WB + R_WB p_BP,   v_WP = v_WB + w_WB × (R_WB p_BP),   w_WP = w_WB.
/// A macro step H = n h makes n steps of OdeWorld; step j = 1…n applies the wrenches that the
/// segment has at j/n (the end value when n = 1) in the pose at the beginning of the step.
/// With IntegratorKind::Verlet the micro step is velocity Verlet with constraints on poses and
/// velocities [Andersen 1983, RATTLE], in ODE's terms:
///   M (u − v) / h = ½ f(x, v, t) + ½ ((1 − b) λ + b λ⁺) + Jᵀ μ,   J(x) u = −(erp / h) φ(x),
///   x⁺ = x ⊕ h u,
///   M (v⁺ − u) / h = ½ f(x⁺, 2 u − v, t + h) + ½ (b λ + (1 − b) λ⁺) + Jᵀ μ⁺,   J(x⁺) v⁺ = 0,
/// two dWorldSteps with half the forces and half the motors' largest efforts; first_half() and
/// second_half() say what softness (cfm) adds. A free body under λ alone moves by Newmark's rule,
///   x⁺ = x + h v + h² ((½ − β) a + β a⁺),   v⁺ = v + ½ h (a + a⁺):
/// β = ¼ is the trapezoidal rule, which adds no limit to the coupling's stability; with β = 1/12
/// its period error is of fourth order, and the coupled system is certain to be stable while
/// ω h < √6 for the rigid bodies on the stiffness of the flexible side's elements at their ports.
/// IntegratorKind::GeneralisedAlpha has λ̄ of WrenchRule in place of λ. The gyroscopic torque
/// −w × I w is part of f.
/// Second order in poses and velocities; limits, motors that saturate and dampers on fast motion
/// are as robust as explicit forces are.
///
/// The result is a pure function of state and request: bit-identical after any rollback.
///
/// Cost: one dWorldStep per micro step, cubic in the number of bodies of one mechanism. With
/// `linearize`, one factorisation that is linear in the bodies of a chain (see KickResponse) where
/// the macro step is one dWorldStep; else, and for every column in which a stop or motor would
/// change its role, a further advance per column, 6 columns a port.
class RigidWorld final : public MbsSide {
 public:
  /// Throws a Usage error when check(params) does.
  explicit RigidWorld(Params params);

  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  /// Motions at t = 0, which do not depend on the wrenches. Joints' velocity errors at t = 0 are
  /// removed by the first step.
  MotionSet initialize(const WrenchSet& wrenches) override;
  StepResult<MotionSet> advance(const StepRequest<WrenchSet>& request) override;
  void checkpoint() override;
  void rollback() override;
  Observation observe() override;

  /// How `linearize` gets its columns: by the step's own response where that holds, or all by
  /// probing.
  enum class Linearization { Response, Probing };
  void linearize_by(Linearization how) { linearization_ = how; }
  /// Columns of the last Jacobian that were probed.
  [[nodiscard]] int probed_columns() const { return probed_columns_; }

  /// Called with every state that checkpoint() accepts, e.g. to write bodies.csv.
  using AcceptedStateSink = std::function<void(const State&)>;
  void on_accepted_state(AcceptedStateSink sink) { sink_ = std::move(sink); }

  [[nodiscard]] const State& state() const { return state_; }
  [[nodiscard]] const Params& params() const { return params_; }

 private:
  struct Port {
    std::size_t body;
    Eigen::Vector3d p_BP;
    Eigen::Quaterniond q_BP;
  };

  [[nodiscard]] SimTime micro_step_of(SimTime macro_step) const;
  [[nodiscard]] MotionSet motions_of(const State& state) const;
  /// Whether a step's works are booked: trials whose state is thrown away need not.
  enum class Booking { On, Off };
  /// Advances `state` by H. Returns what went wrong, or none; `state` is then of no use.
  std::optional<std::string> integrate(State& state, SimTime macro_step,
                                       const Segment<WrenchSet>& input, Booking booking);
  std::optional<std::string> integrate_micro_step(State& state, SimTime h,
                                                  const Segment<WrenchSet>& wrenches,
                                                  Booking booking);
  /// Why the run cannot go on: a body's motion that no mechanism makes, and the springs' part in
  /// it.
  [[nodiscard]] std::string grown(std::size_t body, SimTime t) const;
  /// The poses, velocities and works at the end of a micro step; throws OdeFault.
  void euler_step(State& state, double h_s, const WrenchSet& wrenches, StepWork* work);
  /// By the port's body's rule, `make(rule)` of all ports: that of junctions where it is one.
  template <class Make>
  [[nodiscard]] WrenchSet by_rule(const Make& make) const;
  void verlet_step(State& state, double h_s, const Segment<WrenchSet>& wrenches, StepWork* work);
  enum class Half { First, Second };
  /// One dWorldStep of a Verlet step from `bodies` with the forces of `state` at t_s; what acted is
  /// left in sorted_.
  void half_kick(State& state, double t_s, double h_s, const WrenchSet& wrenches,
                 const std::vector<BodyState>& bodies, Half half);
  void add_gyroscopic_torques(const State& state, std::vector<BodyWrench>& applied);
  void command_motors(const State& state, double h_s, MotorAim aim);
  void add_port_wrenches(const State& state, const WrenchSet& wrenches,
                         std::vector<BodyWrench>& applied);
  /// The joints' coordinates after ODE has moved the bodies for h_s.
  void track_coordinates(State& state, double h_s) const;
  [[nodiscard]] double kinetic_energy_J(const State& state) const;
  /// Keeps a dWorldStep for the response, if one is wanted.
  void record(double h_s, const StepRule& rule, const std::vector<BodyState>& begin,
              const std::vector<std::array<double, 2>>& coordinates,
              const std::vector<BodyWrench>& applied, const std::vector<BodyState>& end);
  std::optional<InterfaceJacobian> linearised(const State& begin, const State& end,
                                              const StepRequest<WrenchSet>& request,
                                              std::string& failure);
  [[nodiscard]] ProbeSizes sizes_of(std::size_t port, SimTime macro_step) const;
  /// Sets the columns that the recorded step's response holds for, and marks them in `found`.
  void respond(const State& end, SimTime macro_step, InterfaceJacobian& jacobian,
               std::vector<bool>& found) const;
  /// One column by an advance of its own; what went wrong, or none.
  std::optional<std::string> probe(Eigen::Index column, const State& begin, const State& end,
                                   const StepRequest<WrenchSet>& request,
                                   InterfaceJacobian& jacobian);

  Params params_;
  SubsystemInfo info_;
  std::vector<Port> ports_;
  Loads loads_;
  WrenchRule rule_;
  WrenchRule junction_rule_;
  OdeWorld world_;
  JointGaps gaps_;
  std::vector<JointGeometry> joints_;
  Linearization linearization_ = Linearization::Response;
  bool recording_ = false;
  std::vector<Kick> kicks_;  ///< of the last macro step that was recorded
  int probed_columns_ = 0;
  bool junctions_ = false;  ///< whether any body is one
  SortedWrenches sorted_;   ///< of the present dWorldStep
  State state_;
  State saved_;
  AcceptedStateSink sink_;
};

}  // namespace tandem::mbs
