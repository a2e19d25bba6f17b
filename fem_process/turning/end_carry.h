#pragma once

#include "fem_process/turning/carry.h"

namespace tandem::fem {

/// Carry of Newmark's family, in the axes at the end of the step. Held parts turn at the mean
/// angular velocity ω of their holders at the beginning of the step, free ones and those on
/// bushings at their own; origin p, v, a, q of the holder (of a free part: means over its mass),
/// blended by φ where there are several. With r = x − p, Q = exp(h [ω]×), ω² r = ω × (ω × r):
///   x̂ = p + Q r,  v̂ = v − ω × r,  â = a_p + Q (a − a_p − ω² r),  q̂ = q_p + Q (q − q_p − ω² r)
/// are what the plain step starts from, to
///   x⁺ = x̂ + (its displacement) + Σ_k φ_k e_k,   M (q⁺ + ω² r̃) + C (y − y_ref) + f(x⁺) = f_ext + …
/// with r̃ = r at x̃, O(h²) from that at the end, and
/// e_k = p_k⁺ − (where the plain step takes the origin of port k, a_p by the same recursion).
/// Then, y being the velocities solved for,
///   v⁺ = v_p⁺ + ω × (x⁺ − p⁺) + Qᵀ (y − v_p⁺),   a⁺ ← a⁺ + ω² (x⁺ − p⁺).
///
/// The origin of a port may go round itself, on a circle that turns with the part: its velocities
/// are differenced with the weight Γ of GeneralisedAlpha. The plain step differences with γ, so
/// it lacks c_a σ_k of q⁺, σ_k of v_k⁺, v_k and a_k in W: spread over the body by φ like e_k.
///
/// In turning axes the motion relative to the holder has Coriolis's acceleration −2 ω × w. It turns
/// w by −2 ω h over the step, half of it before and half after the plain step [Strang 1968]; in W
/// axes the first half leaves v̂ − v_p as it is, the second is Qᵀ. Both halves keep w·w, and the
/// plain step in turning axes has the stability that it has at rest: unconditional, for any ω h,
/// with a symmetric matrix. Coriolis's force in the balance would make it unsymmetric, or explicit
/// and unstable.
///
/// x̃, where forces are linearised, is where the relative velocity of the last step would lead: to
/// O(h²) where the body goes, without what the last acceleration makes of stiff modes that ring.
class EndCarry final : public Carry {
 public:
  EndCarry(const Model& model, const LoosePorts& loose) : Carry(model, loose) {}

  [[nodiscard]] Carried begin(const State& state, double h_s) const override;
  [[nodiscard]] MotionSet seen(const Carried& carried, const MotionSet& end) const override;
  [[nodiscard]] Eigen::VectorXd drift(const Carried& carried, const MotionSet& end) const override;
  [[nodiscard]] Eigen::VectorXd circling(const Carried& carried,
                                         const MotionSet& end) const override;
  [[nodiscard]] LoosePorts::RigidStep rigid(const Carried& carried,
                                            const MotionSet& end) const override;
  void take_mean(const Carried&, Eigen::VectorXd&) const override {
    // Forces are balanced where they stand at the end.
  }
  void see_prescribed(const Carried&, Eigen::VectorXd&) const override {
    // Their accelerations follow from their velocities in W.
  }
  [[nodiscard]] Eigen::VectorXd prescribed_shift(const Carried& carried, const MotionSet& end,
                                                 const Eigen::VectorXd& x,
                                                 const Eigen::VectorXd& v) const override;
  void conclude(const State& begin, const Carried& carried, Made made, State& after) const override;

 private:
  /// Origin of what carries a node, as if it were a node.
  struct Origin {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    Eigen::Vector3d a = Eigen::Vector3d::Zero();
    Eigen::Vector3d q = Eigen::Vector3d::Zero();
  };
  /// What the difference formulas for the acceleration of a port's origin lack of its circle.
  struct Lead {
    std::vector<Eigen::Vector3d> sigma;       ///< of velocities of free nodes (m/s)
    std::vector<Eigen::Vector3d> prescribed;  ///< of accelerations of prescribed ones (m/s²)
  };
  /// X and L of the integrator in the plane that a part turns in.
  static void lead_circles(const Integrator& integrator, double h_s, Carried::Turn& turn);
  [[nodiscard]] Lead lead(const Carried& carried, const MotionSet& end) const;
  /// Σ_k φ_k e_k over the nodes, of one vector per port.
  [[nodiscard]] Eigen::VectorXd spread(const std::vector<Eigen::Vector3d>& of_port) const;
  void refer(std::size_t s, const State& begin, const Carried& carried, const MotionSet& end,
             Eigen::VectorXd& v) const override;
  [[nodiscard]] bool turns_by_itself(const BodyPart& part) const;
  [[nodiscard]] Eigen::Vector3d holders_rate(const BodyPart& part, const MotionSet& ports) const;
  [[nodiscard]] std::vector<Origin> origins(const BodyPart& part, const State& state) const;
  void see(const BodyPart& part, const State& state, const Carried::Turn& turn, Carried& carried,
           Eigen::VectorXd& x_tilde, Eigen::VectorXd& centripetal_a) const;
  void see_rigid(const State& state, Carried& carried) const;
  void turn_prescribed(const State& state, Carried& carried) const;
  void conclude_rigid(const State& begin, const Carried& carried, const Made& made,
                      State& after) const;
};

}  // namespace tandem::fem
