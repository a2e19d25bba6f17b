#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "fem_process/body/model.h"
#include "fem_process/body/state.h"
#include "fem_process/matrix/node_rotations.h"
#include "fem_process/ports/loose_ports.h"
#include "fem_process/ports/port_arms.h"
#include "fem_process/solvers/rest_inverse.h"
#include "fem_process/turning/carry.h"
#include "protocol/contract/port.h"
#include "protocol/contract/subsystem.h"

namespace tandem::fem {

/// Where the time of a step went (s). Zero for what was kept from an earlier call.
struct StepTimes {
  double elements_s = 0.0;   ///< internal forces and stiffness
  double factorize_s = 0.0;  ///< step matrix, its factor or preconditioner
  double solve_s = 0.0;      ///< linear solve
};

/// What one step needs from the state it starts from, whatever its input: kept for repetitions of
/// the step after a rollback.
struct Linearisation {
  std::uint64_t generation = 0;  ///< of the state; 0 = none
  double h_s = 0.0;
  Carried carried;  ///< the state as it turns with the body; of the step's first alone
  StepMap map;
  Eigen::VectorXd f_int;   ///< at x̃ (N)
  Eigen::VectorXd f_mean;  ///< its mean over the step's turn, which enters the balance (N)
  BlockValues K;           ///< at x̃ (N/m)
  int inverted_elements = 0;
  std::unique_ptr<LinearSolver> solver;  ///< of the interior step matrix
  BlockValues S;                         ///< interior step matrix (kg/s)
  std::vector<NodeRotation> rotations;   ///< of the free nodes, for a warped preconditioner
  SolveReport factorisation;
  Eigen::MatrixXd port_columns;   ///< Z = S⁻¹ N of LoosePorts: velocities of the free nodes
  Eigen::MatrixXd port_response;  ///< Y = Nᵀ Z
  /// The macro step's first, whose factor serves this one too: see NearbySolver. Null: an own one.
  Linearisation* neighbour = nullptr;
  /// M v and M (x − x̃) of the state where torques close the angular momentum (kg m/s, kg m).
  Eigen::VectorXd momentum, behind;
  EightVectors S_past;  ///< S times the last velocities, when the initial guess is made of them
  /// A correction's: the step's first, whose stiffness and factor serve it. Null: its own do.
  const Linearisation* first = nullptr;
  [[nodiscard]] const BlockValues& stiffness() const { return first != nullptr ? first->K : K; }
  bool stands_in = false;  ///< K is Σ R K_e Rᵀ, since the exact one has no definite step matrix
  /// How x̃ came about: made from the state, or from the step's first solution for one correction
  /// with the first one's matrix, or at an iterate of Newton's, where x̃ + d is an equilibrium.
  enum class Kind { Predicted, Corrected, Iterated };
  Kind kind = Kind::Predicted;
  /// With a correction or Newton steps: the same at the step's last iterate.
  std::unique_ptr<Linearisation> corrected;
  bool has_correction = false;  ///< `corrected` belongs to the step that was made last
  [[nodiscard]] const Linearisation& last() const { return has_correction ? *corrected : *this; }
};

/// Wrenches of nodal reactions: f_P_W = −Σ g_i, t_P_W = −Σ (p_WP + R_WP r_i − about) × g_i with the
/// pose of `at`, of the ports that have arms: the rigid ones.
[[nodiscard]] WrenchSet port_wrenches(const Model& model, const PortArms& arms,
                                      const TorqueArms& at, const Eigen::VectorXd& react);

/// Arms and points as the ports stand.
[[nodiscard]] TorqueArms arms_at(const MotionSet& motions);

/// Makes single steps of a model. Const but for the scratch it is handed.
class TransientStep {
 public:
  /// For PCG with a rest factor, that of steps of the model's micro step is made here: steps of
  /// other lengths are as good, but take more iterations.
  TransientStep(const Model& model, PortArms arms);

  /// State and wrenches at t = 0: free nodes with the initial velocity field, port nodes with the
  /// port's rigid velocity, accelerations from M_II a_I = (f_ext − f_int − C v)_I − M_Ip a_p with
  /// a_p = w × (w × r), i.e. ports at constant twist: the input says nothing about their
  /// acceleration. Without inertia: the static equilibrium at t = 0.
  SolveReport start(const MotionSet& motions, State& state, WrenchSet& wrenches) const;

  /// The state once the boundary conditions have changed at its time: held nodes at rest where they
  /// are, accelerations and forces of the balance that holds now, no past for initial guesses.
  SolveReport restart(State& state) const;

  /// Whether the factor of a macro step's first micro step saves those of the others time.
  [[nodiscard]] bool shares_factor() const {
    return model_.params.solver.kind == SolverKind::Cholmod && loose_.empty();
  }

  /// Makes now what the next micro step of the model's length would make of its state.
  void prepare(const State& state, Linearisation& kept) const;

  struct Result {
    SolveReport report;
    StepTimes times;
    State state;
    WrenchSet wrenches;
    Eigen::VectorXd d;         ///< x⁺ − x̃ as the balance of forces has it (m)
    Eigen::VectorXd react;     ///< nodal reactions at the end (N)
    Eigen::VectorXd q;         ///< of LoosePorts, where their forces have their arms
    Eigen::VectorXd external;  ///< loads, weight and drag (N)
    Eigen::VectorXd on_nodes;  ///< reactions and forces of LoosePorts (N)
    PortsSeen seen;            ///< port motions as the balance has them, see Carry
    TorqueArms torques;
    Eigen::VectorXd first_damped;    ///< `damped` before a correction
    Eigen::VectorXd first_y;         ///< `y` before a correction, where there are loose ports,
    Eigen::VectorXd first_attached;  ///< and their forces
    Eigen::VectorXd dragged;         ///< velocities in W that α M damps; empty without damping
    Eigen::VectorXd correction;      ///< of the velocities of the free nodes by it (m/s)
    Eigen::VectorXd y;               ///< velocities solved for (m/s)
    Eigen::VectorXd a;               ///< accelerations of the balance (m/s²)
    Eigen::VectorXd damped;          ///< velocities that β K damps (m/s); empty without damping
    LoosePorts::Rates rates;
  };
  /// One step of length h to the motions at its end. `about`: the ports' origins at the beginning
  /// of the macro step, per port. `kept` is filled unless it belongs to this state and h already;
  /// equal bits either way.
  Result advance(const State& begin, const MotionSet& end, const MotionSet& about, SimTime h,
                 Linearisation& kept) const;

  /// Where the forces of such a step have their arms: at its end, with backward Euler where the
  /// half turn of the body takes the ports from its beginning (see AngularBalance for the rest).
  [[nodiscard]] TorqueArms torque_arms(const Carried& carried, const MotionSet& end,
                                       const MotionSet& about) const;
  /// Whether torques close the body's angular momentum.
  [[nodiscard]] bool balances_angular() const {
    return model_.integrator->constant_forces() && model_.integrator->inertia();
  }

  /// d(T f_int(x̃) + K(x̃) y) along dx̃, y held, of what K is in this linearisation.
  [[nodiscard]] Eigen::VectorXd turning(const Linearisation& at, const Eigen::VectorXd& x,
                                        const Eigen::VectorXd& y, const Eigen::VectorXd& dx) const;

  /// Of rigid ports; the others have none.
  [[nodiscard]] const PortArms& arms() const { return arms_; }
  [[nodiscard]] const LoosePorts& loose_ports() const { return loose_; }
  [[nodiscard]] const Carry& carry() const { return *carry_; }

 private:
  /// What a step is made of, beside its linearisation.
  struct Input {
    const State& begin;
    const MotionSet& end;
    const PortsSeen& seen;             ///< `end` as the balance has it
    const Eigen::VectorXd& f_ext;      ///< at the end (N)
    const Eigen::VectorXd& reference;  ///< of Carry; empty without damping
    const Carried& carried;
    const Eigen::VectorXd& shift;  ///< of Carry::prescribed_shift; empty without damping
  };
  SolveReport accelerate(State& state, Eigen::VectorXd& a, Eigen::VectorXd& react) const;
  [[nodiscard]] Eigen::VectorXd commanded_forces(const State& state) const;
  SolveReport settle(const MotionSet& motions, State& state, WrenchSet& wrenches) const;
  /// Returns the times of what it did.
  StepTimes linearise(const State& begin, double h_s, Linearisation& kept) const;
  StepTimes linearise_at_tilde(const Carried& carried, Linearisation& kept) const;
  void factorize(Linearisation& kept) const;
  void stand_in(Linearisation& kept) const;
  Result attempt(const State& begin, const MotionSet& end, const MotionSet& about, SimTime h,
                 Linearisation& kept) const;
  void correct_once(const Input& input, Linearisation& kept, Eigen::VectorXd& v, Eigen::VectorXd& a,
                    Result& result) const;
  void lean_on_neighbour(Linearisation& kept) const;
  SolveReport find_port_columns(Linearisation& kept) const;
  void correct(const Input& input, Linearisation& kept, Eigen::VectorXd& v, Eigen::VectorXd& a,
               Result& result) const;
  void prescribe(const MotionSet& motions, Eigen::VectorXd& x, Eigen::VectorXd& v) const;
  [[nodiscard]] Eigen::VectorXd damped(const Input& input, const Eigen::VectorXd& v) const;
  [[nodiscard]] Eigen::VectorXd dragged(const Input& input, const Eigen::VectorXd& v) const;
  /// M a + C (v − v_ref) + f_int − f_ext (N).
  [[nodiscard]] Eigen::VectorXd balance(const Linearisation& kept, const Input& input,
                                        const Eigen::VectorXd& attached, const Eigen::VectorXd& v,
                                        const Eigen::VectorXd& d, const Eigen::VectorXd& a,
                                        ProductPart part = {}) const;
  /// Corrects v (free nodes: a guess; prescribed nodes: final) to the balance of forces; fills d,
  /// the reactions and the histories of `result`.
  void solve(const Input& input, const Linearisation& kept, Eigen::VectorXd& v, Eigen::VectorXd& a,
             Result& result) const;
  /// Adds what the forces of averaging ports and bushings do.
  SolveReport attach(const Input& input, const Linearisation& kept, Eigen::VectorXd& v,
                     Eigen::VectorXd& a, Result& result) const;
  void pull(const Carried& carried, const Eigen::VectorXd& x_seen, Result& result) const;
  [[nodiscard]] Eigen::VectorXd damping_force(const BlockValues& K, const Eigen::VectorXd& v,
                                              const Eigen::VectorXd& beyond) const;
  [[nodiscard]] bool is_damped() const;
  [[nodiscard]] bool corrects(const Linearisation& kept) const;

  void step_matrix(const StepMap& map, const BlockValues& K, BlockValues& S) const;
  [[nodiscard]] Eigen::VectorXd inertia(const Eigen::VectorXd& a, ProductPart part = {}) const;
  void rest(const StepMap& map, Eigen::VectorXd& v, Eigen::VectorXd& d, Eigen::VectorXd& a) const;
  [[nodiscard]] Eigen::VectorXd multiply_interior(const BlockValues& S,
                                                  const Eigen::VectorXd& v) const;
  [[nodiscard]] bool measures_residuals() const;
  [[nodiscard]] bool remembers() const;
  void remember(const Eigen::VectorXd& v, State& state) const;
  [[nodiscard]] std::unique_ptr<const RestInverse> factorize_at_rest() const;

  const Model& model_;
  PortArms arms_;
  LoosePorts loose_;
  std::unique_ptr<const Carry> carry_;
  NodeRotations node_rotations_;
  /// Of exact tangents: what stands in for them. Null: not needed.
  std::unique_ptr<const Formulation> definite_;
  std::unique_ptr<const RestInverse> rest_;  ///< null: not used
};

}  // namespace tandem::fem
