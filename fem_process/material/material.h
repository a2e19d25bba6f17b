#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

namespace tandem::fem {

/// Elastic constants along three material axes 1, 2, 3 at right angles.
struct Orthotropic {
  Eigen::Vector3d young_Pa = Eigen::Vector3d::Zero();  ///< E_1, E_2, E_3
  /// ν_12, ν_13, ν_23: ν_ij = −ε_j/ε_i in tension along i; ν_ji = ν_ij E_j/E_i.
  Eigen::Vector3d poisson = Eigen::Vector3d::Zero();
  Eigen::Vector3d shear_Pa = Eigen::Vector3d::Zero();  ///< G_12, G_13, G_23
  /// Columns: the axes in W at the reference positions. They turn with the material.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};

/// Linear elastic material, isotropic or orthotropic.
struct Material {
  double young_Pa = 2.1e11;
  double poisson = 0.3;
  double density_kg_per_m3 = 7850.0;
  std::optional<Orthotropic> orthotropic;  ///< in place of E and ν
};

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// σ = D ε, ε = [ε_xx ε_yy ε_zz γ_xy γ_yz γ_zx] (engineering shear), Pa, in W. Orthotropic: the
/// inverse of the compliance
///   ε_i = σ_i/E_i − Σ_j ν_ji σ_j/E_j,  γ_ij = τ_ij/G_ij
/// in the material axes, turned into W.
[[nodiscard]] Matrix6d elasticity(const Material& material);

/// Squared speed (m²/s²) of the fastest wave along a thin rod: the largest E/ρ.
[[nodiscard]] double squared_wave_speed(const Material& material);

/// What is wrong, with the remedy, unless ρ > 0 and the strain energy is positive: E > 0 and
/// −1 < ν < ½, or a positive definite compliance. Empty when nothing is.
[[nodiscard]] std::string defect_of(const Material& material);

/// Throws a Usage error with the defect, if there is one.
void check(const Material& material);

/// Orthonormal axes from axis 1 and a vector in the plane of the axes 1 and 2, neither of unit
/// length nor at right angles to each other. Null when they are parallel or zero.
[[nodiscard]] std::optional<Eigen::Matrix3d> material_axes(const Eigen::Vector3d& axis_1,
                                                           const Eigen::Vector3d& in_plane_12);

}  // namespace tandem::fem
