#pragma once

#include <Eigen/Core>

#include "fem_process/material/material.h"

namespace tandem::fem {

/// Laws of hyperelastic material: the first Piola–Kirchhoff stress P (Pa) as a function of the
/// deformation gradient F, with its exact first and second directional derivatives. What depends on
/// F alone is computed once, in at().

/// The law of the polar co-rotational tetrahedron [Marinkovic & Zehn 2012]:
///   P = R (σ + [a]),  σ = C : (U − I),  F = R U,  (tr U I − U) a = axial(U σ),
/// the gradient of W = ½ (U − I) : C : (U − I). For isotropic C, σ and U commute and a = 0, which
/// leaves the R σ of the paper. For anisotropic C, R σ alone has no potential and makes moments
/// P Fᵀ − F Pᵀ of the order of strain times stress; the antisymmetric [a] takes them away.
/// Derivative of the rotation along A: DR[A] = R [ω], (tr U I − U) ω = axial(Rᵀ A), from the
/// symmetry of U = Rᵀ F [Higham 2008, section 8.2]. Inverted elements (det F ≤ 0) keep R fixed.
class CorotatedLaw {
 public:
  explicit CorotatedLaw(const Matrix6d& C);

  struct Point {
    Eigen::Matrix3d R;
    Eigen::Matrix3d U;
    Eigen::Matrix3d sigma;      ///< Pa, in the rotated axes
    Eigen::Vector3d a;          ///< Pa, zero for isotropic C
    Eigen::Matrix3d T_inverse;  ///< (tr U I − U)⁻¹, zero when inverted
    bool inverted = false;
  };
  [[nodiscard]] Point at(const Eigen::Matrix3d& F) const;
  [[nodiscard]] double energy_density(const Point& point) const;  ///< J/m³
  [[nodiscard]] static Eigen::Matrix3d stress(const Point& point);
  /// DP[A].
  [[nodiscard]] Eigen::Matrix3d derivative(const Point& point, const Eigen::Matrix3d& A) const;
  /// D²P[A, B].
  [[nodiscard]] Eigen::Matrix3d second_derivative(const Point& point, const Eigen::Matrix3d& A,
                                                  const Eigen::Matrix3d& B) const;
  /// The simplified tangent R C : (Rᵀ A): DP[A] without the derivative of R and a.
  [[nodiscard]] Eigen::Matrix3d simplified(const Point& point, const Eigen::Matrix3d& A) const;
  /// Derivative of simplified(point, A), A held, along B.
  [[nodiscard]] Eigen::Matrix3d simplified_derivative(const Point& point, const Eigen::Matrix3d& A,
                                                      const Eigen::Matrix3d& B) const;
  /// Stress for output (Pa): σ, as the simplified formulation has it.
  [[nodiscard]] static Eigen::Matrix3d output_stress(const Point& point) { return point.sigma; }

 private:
  /// What changes along one direction.
  struct Change {
    Eigen::Matrix3d turn;     ///< Ω = Rᵀ DR
    Eigen::Matrix3d stretch;  ///< DU
    Eigen::Matrix3d sigma;    ///< Dσ
    Eigen::Vector3d a;        ///< Da
  };
  [[nodiscard]] Change change(const Point& point, const Eigen::Matrix3d& A_local) const;

  Matrix6d C_;
  bool isotropic_;
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

/// How a formulation's stiffness K follows from its law: as the exact derivative of the stress, or
/// simplified. derivative() is that of the tangent along B.
struct ExactTangent {
  template <class Law>
  static Eigen::Matrix3d value(const Law& law, const typename Law::Point& point,
                               const Eigen::Matrix3d& A) {
    return law.derivative(point, A);
  }
  template <class Law>
  static Eigen::Matrix3d derivative(const Law& law, const typename Law::Point& point,
                                    const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
    return law.second_derivative(point, A, B);
  }
};
struct SimplifiedTangent {
  template <class Law>
  static Eigen::Matrix3d value(const Law& law, const typename Law::Point& point,
                               const Eigen::Matrix3d& A) {
    return law.simplified(point, A);
  }
  template <class Law>
  static Eigen::Matrix3d derivative(const Law& law, const typename Law::Point& point,
                                    const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
    return law.simplified_derivative(point, A, B);
  }
};

/// C : sym(e) as a symmetric tensor (Pa).
[[nodiscard]] Eigen::Matrix3d contract(const Matrix6d& C, const Eigen::Matrix3d& e);

/// √(3/2) |dev σ| (Pa).
[[nodiscard]] double von_mises(const Eigen::Matrix3d& sigma);

}  // namespace tandem::fem
