#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include "fem_process/body/integrator.h"
#include "fem_process/body/state.h"
#include "fem_process/reduced/reduced_model.h"
#include "fem_process/reduced/reduced_turn.h"
#include "fem_process/solvers/linear_solver.h"
#include "protocol/contract/port.h"

namespace tandem::fem {

/// All that changes in a reduced body. A checkpoint is a copy of it.
struct ReducedState {
  SimTime time{};
  MotionSet ports;          ///< the ports' motions
  State modal;              ///< η (m √kg), its rate and what the integrator remembers of them
  State fields;             ///< the same of the fields' motion, in W
  Eigen::VectorXd z;        ///< [ζ; η]
  WrenchSet wrenches;       ///< at this time
  EnergyBook book;          ///< works and losses since t = 0; its energies stay 0
  double turned_rad = 0.0;  ///< largest elastic turn of an element since t = 0, see ElasticTurn
  [[nodiscard]] std::uint64_t hash() const;
};

/// Makes single steps of a reduced body with the integrators of the full one:
///   Φᵀ R_WFᵀ (i⁺ + C v⁺ + f_int⁺ − f_ext⁺) = 0,   θ i⁺ + (1 − θ) i_n = M a⁺,
/// for the modal velocities η̇⁺, all inertia forces of the moving frame included. i is the inertia
/// force at the end of the step; the integrator's a⁺ may belong to another time within it. Poses
/// and velocities of the frame are given, so x⁺, v⁺ and a⁺ of all nodes are affine in η̇⁺: the step
/// is one dense linear system without linearisation.
///
/// The parts' wrenches are conjugate to their motion: λ_b = −(∂x/∂pose_b)ᵀ (i + …), evaluated at
/// the end of the step, or at its beginning where the integrator says so (backward Euler). Then
/// also the change x⁺ − x_n − h v⁺ is booked as Σ (x⁺ − x_n) × M v⁺/h on the frame's turning, so
/// that linear and angular momentum close to round-off over every step when the frame is carried by
/// the parts.
class ReducedStep {
 public:
  explicit ReducedStep(const ReducedModel& reduced) : reduced_(reduced) {}

  /// What a step made on its way; its derivative needs it.
  struct Result {
    SolveReport report;
    ReducedState state;
    WrenchSet wrenches;
    FloatingFrame::Placement begin, end;
    StepMap modal_map, field_map;
    ReducedTurn turn;  ///< field_map is its map
    FieldMotion Y_begin, Y, V;
    FieldMotion balance;          ///< i + α M v − f_ext on the fields (N)
    FieldMotion momentum;         ///< M v (kg m/s)
    Eigen::VectorXd generalised;  ///< of the balance at the ports' pose: force, moment, ζ
    Eigen::PartialPivLU<Eigen::MatrixXd> lu;
    double h_s = 0.0;
  };

  /// State and wrenches at t = 0: modes undeformed, moving as the initial velocity field demands,
  /// ports at constant twist; in statics, modes in equilibrium.
  void start(const MotionSet& ports, ReducedState& state, WrenchSet& wrenches) const;
  [[nodiscard]] Result advance(const ReducedState& begin, const MotionSet& ports, SimTime h) const;

  [[nodiscard]] const ReducedModel& reduced() const { return reduced_; }

 private:
  [[nodiscard]] FieldMotion velocity(const FloatingFrame::Placement& at, const Eigen::VectorXd& eta,
                                     const Eigen::VectorXd& eta_dot) const;
  [[nodiscard]] FieldMotion drift(const FloatingFrame::Placement& at,
                                  const Eigen::VectorXd& eta_dot) const;
  void solve(const ReducedState& begin, const FieldMotion& external, Result& result) const;
  void react(Result& result) const;

  const ReducedModel& reduced_;
};

/// Rayleigh damping; statics passes it over.
[[nodiscard]] Damping damping_of(const Model& model);
/// The history of the fields after a step with the accelerations A: that of A beyond `carried`.
void keep_turning(const Integrator& integrator, const ReducedTurn& turn, Eigen::VectorXd x,
                  Eigen::VectorXd v, const FieldMotion& A, double h_s, State& after);
/// Position, velocity and what the integrator remembers of the accelerations; also of derivatives.
void keep(const Integrator& integrator, const State& begin, Eigen::VectorXd x, Eigen::VectorXd v,
          const Eigen::VectorXd& a, double h_s, State& after);
/// Accelerations c V + â of a motion of the fields: those of rigid parts are prescribed.
[[nodiscard]] FieldMotion acceleration(const ReducedModel& reduced, const StepMap& map,
                                       const FieldMotion& V);
/// Σ_k R e_k · G_k over the three fields of every normal mode.
[[nodiscard]] Eigen::VectorXd modal_forces(const ReducedModel& reduced, const Eigen::Matrix3d& R,
                                           const FieldMotion& G);
/// Forces G on the fields as [force; moment about p_WF; forces on ζ] at the placement Y, R.
[[nodiscard]] Eigen::VectorXd generalised_forces(const ReducedModel& reduced, const FieldMotion& Y,
                                                 const Eigen::Matrix3d& R, const FieldMotion& G);
/// Σ a_c × b_c.
[[nodiscard]] Eigen::Vector3d moment(const FieldMotion& a, const FieldMotion& b);
[[nodiscard]] Eigen::VectorXd flat(const FieldMotion& motion);
[[nodiscard]] WrenchSet wrenches_of(const Eigen::VectorXd& react, std::size_t ports);
[[nodiscard]] Eigen::VectorXd joined(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

}  // namespace tandem::fem
