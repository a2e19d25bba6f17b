#pragma once

#include <Eigen/Core>
#include <vector>

namespace tandem::fem {

using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

/// The k-th Vector12 of many.
[[nodiscard]] inline Vector12 part(const Eigen::VectorXd& all, std::size_t k) {
  return all.segment<12>(12 * static_cast<Eigen::Index>(k));
}

/// The same 3×3 matrix on each of the four 3-vectors of a Vector12.
[[nodiscard]] Matrix12 four_times(const Eigen::Matrix3d& A);

/// How a node set moves on average. With weights w_i of sum 1, arms r_i from the centroid in port
/// axes at t = 0 and ℓ² = Σ w_i |r_i|², twelve fixed linear functionals of the positions say all:
///   q = (x̄, q_1, q_2, q_3),   x̄ = Σ w_i x_i,   q_k = Σ w_i (r_ik/ℓ) x_i   (m).
/// Forces φ conjugate to them are the nodal forces f_i = w_i (φ_0 + Σ_k (r_ik/ℓ) φ_k), of resultant
/// φ_0 and of moment x̄ × φ_0 + Σ_k q_k × φ_k about the origin.
///
/// The least-squares frame (x̄, R̄) of the set makes Σ w_i |x_i − x̄ − R̄ r_i|² smallest:
///   Σ w_i R̄ r_i × (x_i − x̄) = 0,  i.e.  Σ_k R̄ e_k × q_k = 0,
/// for rotations of any size; a rigid motion of the nodes moves it along.
class NodeAverage {
 public:
  /// `arms` from any origin of the port frame, in port axes (m); `weights` of any positive sum.
  NodeAverage(const std::vector<int>& nodes, std::vector<double> weights,
              const std::vector<Eigen::Vector3d>& arms);

  [[nodiscard]] const std::vector<int>& nodes() const { return nodes_; }
  /// Centroid c in port axes: where x̄ stands when the frame of the nodes is the port's (m).
  [[nodiscard]] const Eigen::Vector3d& centroid() const { return centroid_; }
  /// Σ w_i r_i r_iᵀ/ℓ: (q_1 q_2 q_3) in port axes without deformation (m).
  [[nodiscard]] const Eigen::Matrix3d& inertia() const { return inertia_; }
  /// ω with Σ_k e_k × (ω × inertia e_k) = `moment`.
  [[nodiscard]] Eigen::Vector3d turn(const Eigen::Vector3d& moment) const {
    return inverse_turning_ * moment;
  }
  /// Whether the nodes stand in one line, or in one point: then there is no frame.
  [[nodiscard]] bool collinear() const { return collinear_; }

  /// q of a vector over all nodes.
  [[nodiscard]] Vector12 coordinates(const Eigen::VectorXd& x) const;
  /// Adds the nodal forces of φ to f (N), `scale` times.
  void add_forces(const Vector12& phi, double scale, Eigen::VectorXd& f) const;
  /// Weight of node k of the set in q_j, j = 0 … 3.
  [[nodiscard]] double share(std::size_t k, int j) const {
    return shares_(j, static_cast<Eigen::Index>(k));
  }

  /// R̄ of q [Horn 1987]; needs three nodes that are not in line.
  [[nodiscard]] static Eigen::Matrix3d rotation(const Vector12& q);

  /// Rigid part of a nodal field y, from its coordinates η = coordinates(y), when the port frame
  /// stands as R: mean + ω × R r_i with R ω = turn of Σ_k e_k × Rᵀ η_k. Adds `scale` times it to
  /// `field`.
  void add_rigid_part(const Eigen::Matrix3d& R, const Vector12& eta, double scale,
                      Eigen::VectorXd& field) const;
  /// The coordinates of that field.
  [[nodiscard]] Vector12 rigid_part(const Eigen::Matrix3d& R, const Vector12& eta) const;
  /// Adds the field mean + ω × R r_i with the arms r_i from the centroid.
  void add_rigid_field(const Eigen::Matrix3d& R, const Eigen::Vector3d& mean,
                       const Eigen::Vector3d& omega, Eigen::VectorXd& field) const;

 private:
  std::vector<int> nodes_;
  std::vector<Eigen::Vector3d> arms_;  ///< from the centroid, port axes (m)
  Eigen::Matrix4Xd shares_;            ///< w_i (1, r_i/ℓ)
  Eigen::Vector3d centroid_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d inverse_turning_ = Eigen::Matrix3d::Zero();  ///< (tr(inertia) 1 − inertia)⁻¹
  bool collinear_ = false;
  /// R ω of the rigid part of η.
  [[nodiscard]] Eigen::Vector3d turn_of(const Eigen::Matrix3d& R, const Vector12& eta) const;
};

}  // namespace tandem::fem
