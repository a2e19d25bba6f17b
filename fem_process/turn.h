#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace tandem::fem {

/// exp([θ]×): the rotation about θ by |θ| rad.
[[nodiscard]] inline Eigen::Matrix3d turned_by(const Eigen::Vector3d& theta) {
  const double angle = theta.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, theta / angle).toRotationMatrix();
}

/// The rotation vector θ of R, |θ| ≤ π.
[[nodiscard]] inline Eigen::Vector3d turn_of(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn{R};
  return turn.angle() * turn.axis();
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

/// ∫₀^τ ∫₀^s exp(u [w]×) a du ds: how far an acceleration a that turns at the rate w moves a point
/// from rest in the time τ (m).
[[nodiscard]] inline Eigen::Vector3d displacement_of(const Eigen::Vector3d& a,
                                                     const Eigen::Vector3d& w, double tau_s) {
  const double rate = w.norm();
  const double angle = rate * tau_s;
  if (angle < 1e-4) {  // the next terms are below 1e-17 of the first
    return tau_s * tau_s *
           (0.5 * a + tau_s / 6.0 * w.cross(a) +
            tau_s * tau_s / 24.0 * w.cross(Eigen::Vector3d(w.cross(a))));
  }
  const Eigen::Vector3d n = w / rate;
  const Eigen::Vector3d along = n * n.dot(a);
  return 0.5 * tau_s * tau_s * along +
         ((1.0 - std::cos(angle)) * (a - along) + (angle - std::sin(angle)) * n.cross(a)) /
             (rate * rate);
}

/// The acceleration at the end of a time h over which it has turned at the rate w with this mean.
[[nodiscard]] inline Eigen::Vector3d acceleration_after(const Eigen::Vector3d& mean,
                                                        const Eigen::Vector3d& w, double h_s) {
  const Eigen::Vector3d half = 0.5 * h_s * w;
  const double angle = half.norm();
  if (angle < 1e-8) return mean;
  const Eigen::Vector3d n = half / angle;
  const Eigen::Vector3d along = n * n.dot(mean);
  return along + angle / std::sin(angle) * (turned_by(half) * (mean - along));
}

}  // namespace tandem::fem
