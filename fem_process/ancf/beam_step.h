#pragma once

#include <optional>
#include <string>

#include "fem_process/ancf/attachment.h"
#include "fem_process/ancf/beam_state.h"
#include "fem_process/ancf/beam_system.h"
#include "fem_process/ancf/contact_model.h"
#include "protocol/contract/segment.h"
#include "protocol/contract/subsystem.h"

namespace tandem::fem::ancf {

struct StepParams {
  double rho_inf = 0.6;       ///< spectral radius at infinite frequency; 1: no numerical damping
  double tolerance_m = 1e-9;  ///< Newton ends when no unknown changes by more
  int newton_steps = 25;      ///< most iterations before the step is halved
  int halvings = 5;           ///< most of them: 2⁻⁵ of the step is the shortest
  double mass_damping_per_s = 0.0;  ///< α_M of C = α_M M
  bool friction = true;
};

/// Generalised-α time integration [Chung & Hulbert 1993; Arnold & Brüls 2007]
///   α_m = (2ρ − 1)/(ρ + 1), α_f = ρ/(ρ + 1), γ = ½ + α_f − α_m, β = ¼ (γ + ½)²
///   q⁺ = q + h v + h² ((½ − β) A + β A⁺),  v⁺ = v + h ((1 − γ) A + γ A⁺)
///   (1 − α_f) a⁺ + α_f a = (1 − α_m) A⁺ + α_m A,   M a⁺ = f(q⁺, v⁺, t⁺)
/// by Newton's method on the balance at the end of the step. The factorised matrix of an earlier
/// iterate or step is used as long as the iteration contracts with it. Where full steps go round
/// between pieces of the contact law (touching or not, stick or slip) they are shortened until the
/// natural level function ‖S⁻¹ R‖ falls [Deuflhard 2004, §3.3].
class BeamStep {
 public:
  /// `attachments`: of the ends of the chain, which the system's mesh holds as fixed; null: none.
  BeamStep(const BeamSystem& system, const ContactModel& contact, const StepParams& params,
           const Attachments* attachments = nullptr);

  /// Accelerations at the state's q, v: consistent with the forces, A = a; zero at attached ends.
  /// False when the mass matrix is singular.
  bool balance(const MotionSet& motions, BeamState& state, ContactSums& sums) const;

  struct Result {
    Outcome outcome = Outcome::Done;
    std::string message;  ///< empty when Done
    int iterations = 0;
    int factorisations = 0;
    int halvings = 0;  ///< how many steps were cut in two
    BeamState state;
    ContactSums sums;  ///< at the end
  };
  /// One step over the whole segment, of length h.
  [[nodiscard]] Result advance(const BeamState& begin, const Segment<MotionSet>& input,
                               SimTime h) const;

  /// d wrenches / d motions at the end of a step of length h that ended at `state`, 6P × 12P as the
  /// contract has it: with the balance R(q⁺; m) = 0 and its tangent S = −∂R/∂q⁺,
  ///   dλ/dm = ∂λ/∂m + ∂λ/∂q⁺ S⁻¹ ∂R/∂m.
  /// Attached unknowns are functions of m and not among q⁺; they add −∂R/∂q_a ∂q_a/∂m to ∂R/∂m, and
  /// their rates likewise. Exact but for what the tooth forces leave out. Empty when S is singular.
  [[nodiscard]] std::optional<InterfaceJacobian> jacobian(const BeamState& state,
                                                          const MotionSet& motions,
                                                          SimTime h) const;

  [[nodiscard]] const StepParams& params() const { return params_; }
  [[nodiscard]] const BeamSystem& system() const { return system_; }

 private:
  /// Coefficients of a step of length h.
  struct Alpha {
    double am, af, gamma, beta, h;
    [[nodiscard]] double position() const { return beta * h * h; }
    [[nodiscard]] double rate() const { return gamma / (beta * h); }  ///< ∂v⁺/∂q⁺
    [[nodiscard]] double mass() const { return (1.0 - am) / ((1.0 - af) * beta * h * h); }
  };
  [[nodiscard]] Alpha alpha(double h_s) const;
  /// Derivatives at the end of a step as its wrenches have them, see jacobian().
  struct Slopes {
    Eigen::MatrixXd balance;   ///< ∂R/∂m, unknowns × 12P
    Eigen::MatrixXd wrench_q;  ///< (∂λ/∂q⁺)ᵀ, unknowns × 6P
    Eigen::MatrixXd wrench_v;  ///< (∂λ/∂v⁺)ᵀ
    InterfaceJacobian direct;  ///< ∂λ/∂m, 6P × 12P
  };
  void add_touches(const BeamState& state, const MotionSet& motions, Slopes& slopes) const;
  bool add_attachments(const Alpha& alpha, const BeamState& state, const MotionSet& motions,
                       const std::vector<double>& step_matrix, Slopes& slopes) const;
  enum class End { Converged, Stalled, Inverted, Singular };
  struct Try {
    End end = End::Stalled;
    double change_m = 0.0;
  };
  Try newton(const Alpha& alpha, const MotionSet& motions, double t_s, Result& result) const;
  /// Newton's iteration with a matrix of its own for every step, and steps as long as they help.
  Try damped_newton(const Alpha& alpha, const MotionSet& motions, double t_s, int most,
                    ElementArrays& elements, Result& result) const;
  /// Takes the tangent in `elements` as the state's matrix; false when it is singular.
  bool factorize(const Alpha& alpha, const ElementArrays& elements, Result& result) const;
  /// The unknowns of the end of the step change by d.
  static void correct(const Alpha& alpha, const Eigen::VectorXd& d, BeamState& state);
  /// f_ext − f_int + f_contact − α_M M v − M a; false when an element is turned inside out.
  bool imbalance(const BeamState& state, const MotionSet& motions, double t_s, double damping,
                 std::optional<double> theta, ElementArrays& elements, ContactSums& sums,
                 Eigen::VectorXd& r) const;
  /// The same without the rows of fixed and attached unknowns.
  bool residual(const BeamState& state, const MotionSet& motions, double t_s, double damping,
                std::optional<double> theta, ElementArrays& elements, ContactSums& sums,
                Eigen::VectorXd& r) const;
  /// Contact and loads of attached ends at the state as it is: the wrenches, and what the next
  /// step's works need. False: inside out.
  bool note_forces(const MotionSet& motions, BeamState& state, ContactSums& sums) const;
  /// Books the step of length h that led from `begin` to `end`, by trapezoids over Δq:
  ///   external = ½ (f + f⁺)·Δq,  interface = −½ Σ (λ + λ⁺)·Δ(pose),
  ///   damping = α_M Δq·M v̄ + ½ Δq·(f_v + f_v⁺) + ½ h (P + P⁺),  P of contact damping and friction,
  ///   numerical = Δq·M ā − v̄·M Δv.
  void book(const BeamState& begin, double h_s, BeamState& end) const;
  void cut(const BeamState& begin, const Segment<MotionSet>& input, double s0, double s1, SimTime h,
           int depth, Result& result) const;

  const BeamSystem& system_;
  const ContactModel& contact_;
  const Attachments* attachments_;
  StepParams params_;
};

}  // namespace tandem::fem::ancf
