#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <complex>

namespace tandem::fem {

/// exp([θ]×): the rotation about θ by |θ| rad.
[[nodiscard]] inline Eigen::Matrix3d turned_by(const Eigen::Vector3d& theta) {
  const double angle = theta.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, theta / angle).toRotationMatrix();
}

/// The mean over a turn by θ of a vector that turns along, in the axes at the middle of the turn:
///   T = (1/|θ|) ∫ exp(τ [n]×) dτ over τ = −|θ|/2 … |θ|/2 = s 1 + (1 − s) n nᵀ,
///   s = sin(|θ|/2)/(|θ|/2),  θ = |θ| n.
[[nodiscard]] inline Eigen::Matrix3d mean_over(const Eigen::Vector3d& theta) {
  const double angle = theta.norm();
  if (angle < 1e-8) return Eigen::Matrix3d::Identity();  // s = 1 to the last bit
  const Eigen::Vector3d n = theta / angle;
  const double s = std::sin(0.5 * angle) / (0.5 * angle);
  return s * Eigen::Matrix3d::Identity() + (1.0 - s) * n * n.transpose();
}

/// What a complex number does in the plane across an axis n: Re c (1 − n nᵀ) + Im c [n]×.
[[nodiscard]] inline Eigen::Matrix3d across(const Eigen::Vector3d& n, std::complex<double> c) {
  Eigen::Matrix3d turned;
  for (int k = 0; k < 3; ++k) turned.col(k) = n.cross(Eigen::Vector3d(Eigen::Vector3d::Unit(k)));
  return c.real() * (Eigen::Matrix3d::Identity() - n * n.transpose()) + c.imag() * turned;
}

}  // namespace tandem::fem
