#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

namespace tandem {

/// Motion of a port frame P: what the multibody side says. SI, world axes W.
struct Motion {
  Eigen::Vector3d p_WP = Eigen::Vector3d::Zero();            ///< position of Po (m)
  Eigen::Quaterniond q_WP = Eigen::Quaterniond::Identity();  ///< x_W = R(q_WP) x_P, ‖q‖ = 1
  Eigen::Vector3d v_WP = Eigen::Vector3d::Zero();            ///< velocity of Po (m/s)
  Eigen::Vector3d w_WP = Eigen::Vector3d::Zero();            ///< angular velocity (rad/s)
};

/// Wrench λ which the flexible side exerts ON the rigid side at P. World axes, torque about Po.
struct Wrench {
  Eigen::Vector3d f_P_W = Eigen::Vector3d::Zero();  ///< force (N)
  Eigen::Vector3d t_P_W = Eigen::Vector3d::Zero();  ///< torque about Po (N·m)
};

/// One entry per port, in the order of the scenario's port table.
using MotionSet = std::vector<Motion>;
using WrenchSet = std::vector<Wrench>;

/// The inertia that stands in for that of a body without any, so that its multibody side can make a
/// step of it, and how the side integrates: see CounterInertia, which takes it away again.
struct StandInInertia {
  double mass_kg = 0.0;        ///< 0: the port's body has its own inertia
  double inertia_kg_m2 = 0.0;  ///< the same about all axes through Po
  /// Weights of the velocity's update: v⁺ = v + h ((1 − γ) a + γ a⁺) with
  /// (1 − α_m) a⁺ + α_m a = ((1 − α_f) λ⁺ + α_f λ) / m.
  double gamma = 1.0;
  double alpha_m = 0.0;
  double alpha_f = 0.0;
};

/// What a side knows of one port.
struct PortInfo {
  std::string name;
  /// Length (m) that turns torques into forces in the residual norm. The flexible side states the
  /// root-mean-square distance of the port's nodes from Po; 0 = this side has none to offer.
  double length_m = 0.0;
  /// Which of several flexible bodies holds it, counted from 0: a body's ports feel each other
  /// alone.
  std::int32_t body = 0;
  /// The multibody side says it of one port of each body that has no mass of its own.
  StandInInertia stand_in = {};
};

/// λ as one vector, 6 per port: [f_x f_y f_z t_x t_y t_z | …].
[[nodiscard]] Eigen::VectorXd stack(const WrenchSet& wrenches);
[[nodiscard]] WrenchSet unstack_wrenches(const Eigen::VectorXd& stacked);

/// Local difference b ⊖ a of two motions, 12 per port:
///   [p_b − p_a | θ with R_b = exp(θ×) R_a | v_b − v_a | w_b − w_a],   all in W.
[[nodiscard]] Eigen::VectorXd difference(const MotionSet& a, const MotionSet& b);

/// The motions b with difference(a, b) = `xi` (12 per port): b = a ⊕ ξ.
[[nodiscard]] MotionSet displaced(const MotionSet& a, const Eigen::VectorXd& xi);

/// ‖λ‖ = sqrt(Σ_ports |f|² + |t|²/L²): forces in N, torques scaled by the port's length L (m).
[[nodiscard]] double wrench_norm_N(const WrenchSet& wrenches, const std::vector<PortInfo>& ports);

/// ‖ξ‖ of a difference of motions over the time H (s), in m/s: work-conjugate to wrench_norm_N,
///   sqrt(Σ_ports |δp/H|² + |L θ/H|² + |δv|² + |L δw|²).
[[nodiscard]] double motion_norm_m_per_s(const Eigen::VectorXd& xi,
                                         const std::vector<PortInfo>& ports, double H_s);

/// Interface power Σ_ports f·v + t·w (W): what the flexible side delivers to the rigid side.
[[nodiscard]] double interface_power_W(const WrenchSet& wrenches, const MotionSet& motions);

[[nodiscard]] bool all_finite(const WrenchSet& wrenches);
[[nodiscard]] bool all_finite(const MotionSet& motions);

}  // namespace tandem
