#include "fem_process/kernels/polar.h"

#include <Eigen/Dense>
#include <cmath>

namespace tandem::fem {
namespace {

/// R⁻ᵀ det R.
Eigen::Matrix3d cofactor(const Eigen::Matrix3d& R) {
  Eigen::Matrix3d c;
  c.col(0) = R.col(1).cross(R.col(2));
  c.col(1) = R.col(2).cross(R.col(0));
  c.col(2) = R.col(0).cross(R.col(1));
  return c;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& F) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d& U = svd.matrixU();
  const Eigen::Matrix3d& V = svd.matrixV();
  const double sign = (U * V.transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return U * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * V.transpose();
}

}  // namespace

PolarRotation polar_rotation(const Eigen::Matrix3d& F) {
  const double norm = F.norm();
  if (!(F.determinant() > kSingularFraction * norm * norm * norm))
    return {nearest_rotation(F), true};
  Eigen::Matrix3d R = F;
  // Quadratic convergence: a step below 3e-9 ends within 1e-17 of the limit.
  for (int k = 0; k < 30; ++k) {
    const Eigen::Matrix3d c = cofactor(R);
    const double det = R.col(0).dot(c.col(0));
    const double ratio = c.norm() / (det * R.norm());
    const bool near = std::abs(ratio - 1.0) < 1e-2;
    const double zeta = near ? 1.0 : std::sqrt(ratio);
    const Eigen::Matrix3d next = 0.5 * (zeta * R + c / (zeta * det));
    const double change = (next - R).squaredNorm();
    R = next;
    if (change < 1e-17) break;
  }
  return {R, false};
}

}  // namespace tandem::fem
