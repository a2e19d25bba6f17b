#include "fem_process/material/stress_law.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "fem_process/kernels/cross_matrix.h"
#include "fem_process/kernels/polar.h"

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

Vector3d axial(const Matrix3d& M) {
  return {M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1)};
}

/// tr U I − U: [w] U + U [w] = [(tr U I − U) w] for symmetric U.
Matrix3d spin_matrix(const Matrix3d& U) { return U.trace() * Matrix3d::Identity() - U; }

}  // namespace

Matrix3d contract(const Matrix6d& C, const Matrix3d& e) {
  const Vector6d s = C * strain_vector(e);
  Matrix3d sigma;
  sigma << s(0), s(3), s(5), s(3), s(1), s(4), s(5), s(4), s(2);
  return sigma;
}

CorotatedLaw::CorotatedLaw(const Matrix6d& C) : C_(C) {
  const double lambda = C(0, 1);
  const double mu = C(3, 3);
  Matrix6d isotropic = Matrix6d::Zero();
  isotropic.topLeftCorner<3, 3>().setConstant(lambda);
  isotropic.diagonal() << lambda + 2.0 * mu, lambda + 2.0 * mu, lambda + 2.0 * mu, mu, mu, mu;
  isotropic_ = (C.array() == isotropic.array()).all();
}

CorotatedLaw::Point CorotatedLaw::at(const Matrix3d& F) const {
  const PolarRotation polar = polar_rotation(F);
  Point point;
  point.R = polar.R;
  point.U = polar.R.transpose() * F;
  point.sigma = contract(C_, point.U - Matrix3d::Identity());
  point.inverted = polar.inverted;
  point.T_inverse =
      polar.inverted ? Matrix3d(Matrix3d::Zero()) : Matrix3d(spin_matrix(point.U).inverse());
  point.a = isotropic_ ? Vector3d(Vector3d::Zero())
                       : Vector3d(point.T_inverse * axial(point.U * point.sigma));
  return point;
}

double CorotatedLaw::energy_density(const Point& point) const {
  return 0.5 * (point.sigma.cwiseProduct(point.U - Matrix3d::Identity())).sum();
}

Matrix3d CorotatedLaw::stress(const Point& point) {
  return point.R * (point.sigma + cross_matrix(point.a));
}

/// Da from the derivative of U [a] + [a] U = U σ − σ U, whose axial vector is
/// 2 (tr U I − U) a = 2 axial(U σ).
CorotatedLaw::Change CorotatedLaw::change(const Point& point, const Matrix3d& A_local) const {
  Change change;
  change.turn = cross_matrix(point.T_inverse * axial(A_local));
  change.stretch = A_local - change.turn * point.U;
  change.sigma = contract(C_, change.stretch);
  change.a.setZero();
  if (!isotropic_) {
    change.a = point.T_inverse * (axial(change.stretch * point.sigma + point.U * change.sigma) -
                                  spin_matrix(change.stretch) * point.a);
  }
  return change;
}

Matrix3d CorotatedLaw::derivative(const Point& point, const Matrix3d& A) const {
  const Change along = change(point, point.R.transpose() * A);
  return point.R *
         (along.turn * (point.sigma + cross_matrix(point.a)) + along.sigma + cross_matrix(along.a));
}

/// With Ω_A = [ω_A], U_A = Rᵀ A − Ω_A U, T = tr U I − U and Σ = σ + [a]:
///   T ω_AB = axial(−Ω_B Rᵀ A) − (tr U_B I − U_B) ω_A,
///   U_AB = −Ω_B Rᵀ A − Ω_AB U − Ω_A U_B,
///   T a_AB = axial(U_AB σ + U_A σ_B + U_B σ_A + U σ_AB) − T_B a_A − T_A a_B − T_AB a,
///   D²P = R (Ω_B (Ω_A Σ + Σ_A) + Ω_AB Σ + Ω_A Σ_B + Σ_AB).
Matrix3d CorotatedLaw::second_derivative(const Point& point, const Matrix3d& A,
                                         const Matrix3d& B) const {
  const Matrix3d A_local = point.R.transpose() * A;
  const Change a = change(point, A_local);
  const Change b = change(point, point.R.transpose() * B);
  const Matrix3d A_turned = -b.turn * A_local;
  const Vector3d w_A(a.turn(2, 1), a.turn(0, 2), a.turn(1, 0));
  const Matrix3d turn_AB =
      cross_matrix(point.T_inverse * (axial(A_turned) - spin_matrix(b.stretch) * w_A));
  const Matrix3d stretch_AB = A_turned - turn_AB * point.U - a.turn * b.stretch;
  Matrix3d sum_AB = contract(C_, stretch_AB);
  Matrix3d sum = point.sigma;
  Matrix3d sum_A = a.sigma;
  Matrix3d sum_B = b.sigma;
  if (!isotropic_) {
    const Vector3d a_AB =
        point.T_inverse * (axial(stretch_AB * point.sigma + a.stretch * b.sigma +
                                 b.stretch * a.sigma + point.U * sum_AB) -
                           spin_matrix(b.stretch) * a.a - spin_matrix(a.stretch) * b.a -
                           spin_matrix(stretch_AB) * point.a);
    sum += cross_matrix(point.a);
    sum_A += cross_matrix(a.a);
    sum_B += cross_matrix(b.a);
    sum_AB += cross_matrix(a_AB);
  }
  return point.R * (b.turn * (a.turn * sum + sum_A) + turn_AB * sum + a.turn * sum_B + sum_AB);
}

Matrix3d CorotatedLaw::simplified(const Point& point, const Matrix3d& A) const {
  return point.R * contract(C_, point.R.transpose() * A);
}

Matrix3d CorotatedLaw::simplified_derivative(const Point& point, const Matrix3d& A,
                                             const Matrix3d& B) const {
  const Matrix3d A_local = point.R.transpose() * A;
  const Matrix3d turn = cross_matrix(point.T_inverse * axial(point.R.transpose() * B));
  return point.R * (turn * contract(C_, A_local) - contract(C_, turn * A_local));
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
