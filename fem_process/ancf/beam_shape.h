#pragma once

#include <Eigen/Core>
#include <vector>

namespace tandem::fem::ancf {

/// Vectors of a beam element: r¹, r_x¹, r_y¹, r_z¹, r², r_x², r_y², r_z².
inline constexpr int kVectors = 8;
inline constexpr int kCoordinates = 3 * kVectors;

/// Rectangular cross-section: y in [−w/2, w/2], z in [−h/2, h/2].
struct BeamSection {
  double width_m = 0.0;
  double height_m = 0.0;
  [[nodiscard]] double area_m2() const { return width_m * height_m; }
};

/// The vectors e_a of an element (m, and 1 for gradients), as columns.
using BeamVectors = Eigen::Matrix<double, 3, kVectors>;

/// Shape functions s_a of the fully parameterised beam element: r(x, y, z) = Σ s_a e_a with x = l
/// ξ.
///   s1 = 1 − 3ξ² + 2ξ³   s2 = l(ξ − 2ξ² + ξ³)   s3 = y(1 − ξ)   s4 = z(1 − ξ)
///   s5 = 3ξ² − 2ξ³       s6 = l(ξ³ − ξ²)        s7 = yξ         s8 = zξ
/// [Yakoub & Shabana 2001; eq. (4) of JC11]
[[nodiscard]] Eigen::Matrix<double, kVectors, 1> shape_values(double length_m, double xi, double y,
                                                              double z);

/// ∂s_a/∂(x, y, z) as rows (1/m for vectors 1 and 5, else without unit).
[[nodiscard]] Eigen::Matrix<double, kVectors, 3> shape_gradients(double length_m, double xi,
                                                                 double y, double z);

/// A point of an element whose stress-free vectors are `reference`, J₀ = Σ e_a ⊗ ∇s_a.
struct StressFree {
  /// J₀⁻¹ Q₀, Q₀ the axes of the section: z along r_z, x normal to it and r_y. F times it has its
  /// columns in these axes, where laws that tell them apart need them.
  Eigen::Matrix3d inverse;
  /// Per dx dy dz: det J₀ over what its section is smaller than the nodes' ones between which it is
  /// interpolated: a curved band is as thick between its nodes as there.
  double volume = 1.0;
};
[[nodiscard]] StressFree stress_free(const BeamVectors& reference, double length_m, double xi,
                                     double y, double z);

/// The covariant components C = J_eᵀ J_e with those across, C_yy, C_zz and C_yz, linear between the
/// nodes: assumed natural strains.
[[nodiscard]] Eigen::Matrix3d assumed_metric(const BeamVectors& e, double length_m, double xi,
                                             double y, double z);

/// The same as stress_free() for these: T with Tᵀ C₀ T = I, in the same axes, and √det C₀.
[[nodiscard]] StressFree assumed_stress_free(const BeamVectors& reference, double length_m,
                                             double xi, double y, double z);

/// Points and weights of the Gauss-Legendre rule on [0, 1], exact to degree 2n − 1.
struct GaussRule {
  std::vector<double> point, weight;
};
[[nodiscard]] GaussRule gauss_rule(int n);

/// Scalar mass matrix m_ab = ∫ ρ s_a s_b dV of a straight stress-free element (kg, with lengths of
/// the gradient coordinates): M = m_ab ⊗ I₃ is constant, so there are no Coriolis or centrifugal
/// terms. Closed form.
[[nodiscard]] Eigen::Matrix<double, kVectors, kVectors> mass_matrix(double density_kg_per_m3,
                                                                    double length_m,
                                                                    const BeamSection& section);

/// The same by quadrature for an element whose stress-free vectors are `reference`:
/// dV = StressFree::volume dx dy dz.
[[nodiscard]] Eigen::Matrix<double, kVectors, kVectors> mass_matrix(double density_kg_per_m3,
                                                                    double length_m,
                                                                    const BeamSection& section,
                                                                    const BeamVectors& reference);

}  // namespace tandem::fem::ancf
