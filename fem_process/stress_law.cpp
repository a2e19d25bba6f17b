#include "fem_process/stress_law.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "fem_process/polar.h"

namespace tandem::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Symmetric part as a strain vector, rows as in elasticity().
Vector6d strain_vector(const Matrix3d& e) {
  Vector6d v;
  v << e(0, 0), e(1, 1), e(2, 2), e(0, 1) + e(1, 0), e(1, 2) + e(2, 1), e(2, 0) + e(0, 2);
  return v;
}

/// C : sym(e) as a symmetric tensor.
Matrix3d contract(const Matrix6d& C, const Matrix3d& e) {
  const Vector6d s = C * strain_vector(e);
  Matrix3d sigma;
  sigma << s(0), s(3), s(5), s(3), s(1), s(4), s(5), s(4), s(2);
  return sigma;
}

Vector3d axial(const Matrix3d& M) {
  return {M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1)};
}

Matrix3d cross_matrix(const Vector3d& w) {
  Matrix3d W;
  W << 0, -w(2), w(1), w(2), 0, -w(0), -w(1), w(0), 0;
  return W;
}

}  // namespace

CorotatedLaw::Point CorotatedLaw::at(const Matrix3d& F) const {
  const PolarRotation polar = polar_rotation(F);
  Point point;
  point.R = polar.R;
  point.U = polar.R.transpose() * F;
  point.sigma = contract(C_, point.U - Matrix3d::Identity());
  point.inverted = polar.inverted;
  point.T_inverse = polar.inverted
                        ? Matrix3d(Matrix3d::Zero())
                        : Matrix3d((point.U.trace() * Matrix3d::Identity() - point.U).inverse());
  return point;
}

double CorotatedLaw::energy_density(const Point& point) const {
  return 0.5 * (point.sigma.cwiseProduct(point.U - Matrix3d::Identity())).sum();
}

Matrix3d CorotatedLaw::derivative(const Point& point, const Matrix3d& A) const {
  const Matrix3d A_local = point.R.transpose() * A;
  const Matrix3d turn = cross_matrix(point.T_inverse * axial(A_local));
  return point.R * (turn * point.sigma + contract(C_, A_local - turn * point.U));
}

/// With Ω_A = [ω_A], U_A = Rᵀ A − Ω_A U and T = tr U I − U:
///   T ω_AB = axial(−Ω_B Rᵀ A) − (tr U_B I − U_B) ω_A,
///   U_AB = −Ω_B Rᵀ A − Ω_AB U − Ω_A U_B,
///   D²P = R (Ω_B (Ω_A σ + C:U_A) + Ω_AB σ + Ω_A C:U_B + C:U_AB).
Matrix3d CorotatedLaw::second_derivative(const Point& point, const Matrix3d& A,
                                         const Matrix3d& B) const {
  const Matrix3d A_local = point.R.transpose() * A;
  const Matrix3d B_local = point.R.transpose() * B;
  const Vector3d w_A = point.T_inverse * axial(A_local);
  const Matrix3d turn_A = cross_matrix(w_A);
  const Matrix3d turn_B = cross_matrix(point.T_inverse * axial(B_local));
  const Matrix3d U_B = B_local - turn_B * point.U;
  const Matrix3d A_turned = -turn_B * A_local;
  const Matrix3d T_B = U_B.trace() * Matrix3d::Identity() - U_B;
  const Matrix3d turn_AB = cross_matrix(point.T_inverse * (axial(A_turned) - T_B * w_A));
  const Matrix3d sigma_A = contract(C_, A_local - turn_A * point.U);
  const Matrix3d sigma_AB = contract(C_, A_turned - turn_AB * point.U - turn_A * U_B);
  return point.R * (turn_B * (turn_A * point.sigma + sigma_A) + turn_AB * point.sigma +
                    turn_A * contract(C_, U_B) + sigma_AB);
}

StVenantKirchhoffLaw::Point StVenantKirchhoffLaw::at(const Matrix3d& F) const {
  const Matrix3d E = 0.5 * (F.transpose() * F - Matrix3d::Identity());
  return {F, contract(C_, E), F.determinant() <= 0.0};
}

double StVenantKirchhoffLaw::energy_density(const Point& point) const {
  const Matrix3d E = 0.5 * (point.F.transpose() * point.F - Matrix3d::Identity());
  return 0.5 * point.S.cwiseProduct(E).sum();
}

Matrix3d StVenantKirchhoffLaw::derivative(const Point& point, const Matrix3d& A) const {
  return A * point.S + point.F * contract(C_, point.F.transpose() * A);
}

Matrix3d StVenantKirchhoffLaw::second_derivative(const Point& point, const Matrix3d& A,
                                                 const Matrix3d& B) const {
  return A * contract(C_, point.F.transpose() * B) + B * contract(C_, point.F.transpose() * A) +
         point.F * contract(C_, B.transpose() * A);
}

Matrix3d StVenantKirchhoffLaw::output_stress(const Point& point) {
  // A flat element has no Cauchy stress; its size is all that is left to say.
  const double J =
      std::max(std::abs(point.F.determinant()), std::numeric_limits<double>::epsilon());
  return point.F * point.S * point.F.transpose() / J;
}

double von_mises(const Matrix3d& sigma) {
  const Matrix3d deviator = sigma - sigma.trace() / 3.0 * Matrix3d::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

}  // namespace tandem::fem
