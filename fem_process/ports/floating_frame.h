#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "protocol/contract/port.h"

namespace tandem::fem {

/// The floating frame F of a body whose boundary consists of rigid parts b, and the local motion ζ
/// of the parts in it. Weights c_b ≥ 0 with Σ c_b = 1 say which parts carry it: one part alone, the
/// mean of all; with no weight at all F stands still in W.
///   p_WF = X_F + Σ c_b (p_b − p_b0),   q_WF = Q/|Q|,  Q = Σ c_b q_b
///   t_b = R_WFᵀ (p_b − p_WF) − (p_b0 − X_F),   θ_b = 2 vec(q_WF* q_b)
///   ζ = [t_1 θ_1 | t_2 θ_2 | …]
/// q_b are rotations since t = 0. A rigid motion of all parts moves F with them and leaves ζ = 0. θ
/// is the rotation vector but for |θ|³/24. Everything is a smooth function of the poses.
class FloatingFrame {
 public:
  /// Motions of the parts at t = 0. `still`: X_F when no part carries the frame.
  FloatingFrame(MotionSet begin, std::vector<double> weights, const Eigen::Vector3d& still);

  /// Where everything stands and how fast it moves.
  struct Placement {
    Eigen::Vector3d p_WF, v_WF, w_WF;
    Eigen::Matrix3d R_WF;
    Eigen::VectorXd z, z_dot;  ///< ζ and its rate
    /// [δp_WF; δφ_WF; δζ] = jacobian [δp_1; δφ_1; δp_2; …], δφ turning in W; velocities likewise.
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd twists;  ///< [v_1; w_1; v_2; …]
    /// Smallest cos(φ/2) of the angles φ between a part and F.
    double least_cosine = 1.0;
    int turned_most = 0;  ///< the part it belongs to

    // What the derivatives need: per part.
    std::vector<Eigen::Quaterniond> q;
    std::vector<Eigen::Vector3d> arm;             ///< p_b − p_WF (m)
    Eigen::Vector4d Q = Eigen::Vector4d::Zero();  ///< coefficients x, y, z, w
  };
  [[nodiscard]] Placement place(const MotionSet& motions) const;

  /// Derivative of a placement along changes of the parts' motions, per part [δp; δφ; δv; δw].
  struct Change {
    Eigen::Vector3d p_WF, v_WF, w_WF;
    Eigen::Matrix3d R_WF;
    Eigen::VectorXd z, z_dot;
    Eigen::MatrixXd jacobian;
  };
  [[nodiscard]] Change change(const Placement& at, const Eigen::VectorXd& motions) const;

  [[nodiscard]] std::size_t parts() const { return begin_.size(); }
  [[nodiscard]] const Eigen::Vector3d& reference() const { return X_F_; }

 private:
  /// How fast the frame turns with part b: δφ_WF = Σ D_b δφ_b.
  [[nodiscard]] Eigen::Matrix3d share(const Placement& at, std::size_t b) const;

  MotionSet begin_;
  std::vector<double> weights_;
  Eigen::Vector3d X_F_;
};

}  // namespace tandem::fem
