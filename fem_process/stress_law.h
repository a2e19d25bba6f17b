#pragma once

#include <Eigen/Core>

#include "fem_process/material.h"

namespace tandem::fem {

/// Laws of hyperelastic material: the first Piola–Kirchhoff stress P (Pa) as a function of the
/// deformation gradient F, with its exact first and second directional derivatives. What depends on
/// F alone is computed once, in at().

/// The law of the polar co-rotational tetrahedron [Marinkovic & Zehn 2012]:
///   P = R σ,  σ = C : (U − I),  F = R U.
/// For isotropic C it is the gradient of W = μ |U − I|² + λ/2 tr²(U − I), since σ U is symmetric.
/// Derivative of the rotation along A: DR[A] = R [ω], (tr U I − U) ω = axial(Rᵀ A), from the
/// symmetry of U = Rᵀ F [Higham 2008, section 8.2]. Inverted elements (det F ≤ 0) keep R fixed.
class CorotatedLaw {
 public:
  explicit CorotatedLaw(const Matrix6d& C) : C_(C) {}

  struct Point {
    Eigen::Matrix3d R;
    Eigen::Matrix3d U;
    Eigen::Matrix3d sigma;      ///< Pa, in the rotated axes
    Eigen::Matrix3d T_inverse;  ///< (tr U I − U)⁻¹, zero when inverted
    bool inverted = false;
  };
  [[nodiscard]] Point at(const Eigen::Matrix3d& F) const;
  [[nodiscard]] double energy_density(const Point& point) const;  ///< J/m³
  [[nodiscard]] static Eigen::Matrix3d stress(const Point& point) { return point.R * point.sigma; }
  /// DP[A].
  [[nodiscard]] Eigen::Matrix3d derivative(const Point& point, const Eigen::Matrix3d& A) const;
  /// D²P[A, B].
  [[nodiscard]] Eigen::Matrix3d second_derivative(const Point& point, const Eigen::Matrix3d& A,
                                                  const Eigen::Matrix3d& B) const;
  /// Stress for output (Pa): σ, as the simplified formulation has it.
  [[nodiscard]] static Eigen::Matrix3d output_stress(const Point& point) { return point.sigma; }

 private:
  Matrix6d C_;
};

/// St. Venant–Kirchhoff, what CalculiX and others do for *ELASTIC with NLGEOM:
///   P = F S,  S = C : E,  E = ½ (Fᵀ F − I).
class StVenantKirchhoffLaw {
 public:
  explicit StVenantKirchhoffLaw(const Matrix6d& C) : C_(C) {}

  struct Point {
    Eigen::Matrix3d F;
    Eigen::Matrix3d S;  ///< Pa
    bool inverted = false;
  };
  [[nodiscard]] Point at(const Eigen::Matrix3d& F) const;
  [[nodiscard]] double energy_density(const Point& point) const;  ///< J/m³
  [[nodiscard]] static Eigen::Matrix3d stress(const Point& point) { return point.F * point.S; }
  /// DP[A].
  [[nodiscard]] Eigen::Matrix3d derivative(const Point& point, const Eigen::Matrix3d& A) const;
  /// D²P[A, B].
  [[nodiscard]] Eigen::Matrix3d second_derivative(const Point& point, const Eigen::Matrix3d& A,
                                                  const Eigen::Matrix3d& B) const;
  /// Stress for output (Pa): Cauchy's F S Fᵀ / det F.
  [[nodiscard]] static Eigen::Matrix3d output_stress(const Point& point);

 private:
  Matrix6d C_;
};

/// √(3/2) |dev σ| (Pa).
[[nodiscard]] double von_mises(const Eigen::Matrix3d& sigma);

}  // namespace tandem::fem
