#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "tests/support/jacobi_elliptic.h"

namespace tandem::mbs::testing {

/// Exact motion of a body without torque, I1 < I2 < I3, that turns mainly about axis 3
/// (M² > 2 E I2), with Ω2(0) = 0 [Landau & Lifshitz, Mechanics, § 37]:
///   Ω1 = √((2EI3 − M²)/(I1(I3 − I1))) cn τ,   Ω2 = √((2EI3 − M²)/(I2(I3 − I2))) sn τ,
///   Ω3 = √((M² − 2EI1)/(I3(I3 − I1))) dn τ,   τ = t √((I3 − I2)(M² − 2EI1)/(I1 I2 I3)),
///   k² = (I2 − I1)(2EI3 − M²)/((I3 − I2)(M² − 2EI1)).
/// World axes have z along the angular momentum M; attitude R_WB = Rz(ψ) Rx(θ) Rz(φ) with
///   M e_z in B = (M sin θ sin φ, M sin θ cos φ, M cos θ),
///   dψ/dt = M (I1 Ω1² + I2 Ω2²)/(I1² Ω1² + I2² Ω2²),   ψ(0) = 0.
class FreeAsymmetricTop {
 public:
  /// Principal moments (kg m²) and the two nonzero components of Ω at t = 0 (rad/s, axes of B).
  FreeAsymmetricTop(const Eigen::Vector3d& moments, double omega1, double omega3) : I_(moments) {
    twice_energy_ = I_[0] * omega1 * omega1 + I_[2] * omega3 * omega3;
    momentum_ = std::hypot(I_[0] * omega1, I_[2] * omega3);
  }

  /// Ω in body axes (rad/s).
  [[nodiscard]] Eigen::Vector3d angular_velocity_B(double t) const {
    const double slow = twice_energy_ * I_[2] - momentum_ * momentum_;
    const double fast = momentum_ * momentum_ - twice_energy_ * I_[0];
    const double rate = std::sqrt((I_[2] - I_[1]) * fast / I_.prod());
    const double k = std::sqrt((I_[1] - I_[0]) * slow / ((I_[2] - I_[1]) * fast));
    const JacobiElliptic f = jacobi_elliptic(rate * t, k);
    return {std::sqrt(slow / (I_[0] * (I_[2] - I_[0]))) * f.cn,
            std::sqrt(slow / (I_[1] * (I_[2] - I_[1]))) * f.sn,
            std::sqrt(fast / (I_[2] * (I_[2] - I_[0]))) * f.dn};
  }

  [[nodiscard]] Eigen::Quaterniond attitude(double t) const {
    const Eigen::Vector3d m = I_.cwiseProduct(angular_velocity_B(t)) / momentum_;
    const double theta = std::acos(m[2]);
    const double phi = std::atan2(m[0], m[1]);
    return Eigen::AngleAxisd(precession(t), Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(theta, Eigen::Vector3d::UnitX()) *
           Eigen::AngleAxisd(phi, Eigen::Vector3d::UnitZ());
  }

  [[nodiscard]] double momentum() const { return momentum_; }

 private:
  /// ψ(t) by Simpson's rule on the closed-form rate; 2000 intervals leave below 1e-13 rad for the
  /// few turns used here.
  [[nodiscard]] double precession(double t) const {
    constexpr int kIntervals = 2000;
    const double h = t / kIntervals;
    double sum = precession_rate(0.0) + precession_rate(t);
    for (int i = 1; i < kIntervals; ++i) sum += (i % 2 == 1 ? 4.0 : 2.0) * precession_rate(i * h);
    return sum * h / 3.0;
  }

  [[nodiscard]] double precession_rate(double t) const {
    const Eigen::Vector3d w = angular_velocity_B(t);
    const double a = I_[0] * w[0] * w[0];
    const double b = I_[1] * w[1] * w[1];
    return momentum_ * (a + b) / (I_[0] * a + I_[1] * b);
  }

  Eigen::Vector3d I_;
  double twice_energy_ = 0.0;
  double momentum_ = 0.0;
};

}  // namespace tandem::mbs::testing
