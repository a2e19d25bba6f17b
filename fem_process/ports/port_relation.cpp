#include "fem_process/ports/port_relation.h"

#include <Eigen/Dense>
#include <cmath>

#include "fem_process/kernels/cross_matrix.h"

namespace tandem::fem {
namespace {

Eigen::Vector3d triple(const Vector12& q, int j) { return q.segment<3>(3 * j); }

/// Σ_k a_k × b_k over the last three 3-vectors.
Eigen::Vector3d sum_of_crosses(const Eigen::Matrix3d& a, const Vector12& b) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) sum += a.col(k).cross(triple(b, k + 1));
  return sum;
}

/// H = Σ_k (b_k·q_k) 1 − q_k b_kᵀ, so that Σ_k b_k × (ω × q_k) = H ω.
Eigen::Matrix3d turning(const Eigen::Matrix3d& b, const Vector12& q) {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 3; ++k) {
    H.diagonal().array() += b.col(k).dot(triple(q, k + 1));
    H -= triple(q, k + 1) * b.col(k).transpose();
  }
  return H;
}

/// b = 1/θ² − (1 + cos θ)/(2 θ sin θ) = (1 − ½ θ cot ½θ)/θ² and db/d(θ²).
struct Curvature {
  double b = 0.0;
  double slope = 0.0;
};
Curvature curvature(double square) {
  // The series' next terms are below 1e-17 there.
  if (square < 1e-3) {
    return {1.0 / 12 + square * (1.0 / 720 + square * (1.0 / 30240 + square / 1209600)),
            1.0 / 720 + square * (1.0 / 15120 + square / 403200)};
  }
  const double angle = std::sqrt(square);
  const double half = 0.5 * angle;
  const double cot = std::cos(half) / std::sin(half);
  const double b = (1.0 - half * cot) / square;
  const double d_half_cot = cot - half / (std::sin(half) * std::sin(half));
  return {b, -d_half_cot / (4.0 * angle * square) - b / square};
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn{Eigen::Quaterniond(R)};
  return turn.angle() * turn.axis();
}

}  // namespace

PortView port_view(const Motion& motion, const Eigen::Matrix3d& back, const Vector12& q,
                   const Vector12& q_rate, const Vector12& phi) {
  const Eigen::Matrix3d R_PW = motion.q_WP.toRotationMatrix().transpose();
  const Eigen::Matrix3d of_rates = R_PW * back;
  PortView view{.q = q, .u = q_rate, .w = of_rates * motion.w_WP, .phi = phi};
  view.q.head<3>() -= motion.p_WP;
  view.u.head<3>() -= motion.v_WP;
  view.q = four_times(R_PW) * view.q;
  view.u = four_times(of_rates) * view.u;
  view.phi = four_times(R_PW) * view.phi;
  return view;
}

Vector12 averaged(const NodeAverage& average, const Vector12& q) {
  Vector12 moved = q;
  moved.head<3>() = average.centroid();
  const Eigen::Vector3d turn = average.turn(sum_of_crosses(Eigen::Matrix3d::Identity(), q));
  for (int k = 0; k < 3; ++k) {
    moved.segment<3>(3 * (k + 1)) -= turn.cross(average.inertia().col(k));
  }
  return moved;
}

PortRelation averaging_relation(const NodeAverage& average, const PortView& view) {
  const Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  const Vector12 q = averaged(average, view.q);
  Matrix12 d_averaged = Matrix12::Zero();
  for (int c = 3; c < 12; ++c) {
    d_averaged.col(c) = averaged(average, Vector12::Unit(c));
    d_averaged.col(c).head<3>().setZero();
  }
  PortRelation relation{.F = Vector12::Zero(),
                        .F_q = Matrix12::Zero(),
                        .F_u = Matrix12::Zero(),
                        .F_w = Eigen::Matrix<double, 12, 3>::Zero(),
                        .F_phi = Matrix12::Zero()};
  const Vector12 rate = view.u - four_times(cross_matrix(view.w)) * q;
  relation.F.head<3>() = rate.head<3>();
  relation.F.segment<3>(3) = sum_of_crosses(axes, rate);
  // Of the rates, then of q and w within them.
  Eigen::Matrix<double, 6, 12> of_rate = Eigen::Matrix<double, 6, 12>::Zero();
  of_rate.topLeftCorner<3, 3>() = axes;
  for (int k = 0; k < 3; ++k) of_rate.block<3, 3>(3, 3 * (k + 1)) = cross_matrix(axes.col(k));
  relation.F_u.topRows<6>() = of_rate;
  relation.F_q.topRows<6>() = -of_rate * four_times(cross_matrix(view.w)) * d_averaged;
  relation.F_w.topRows<3>() = cross_matrix(average.centroid());
  relation.F_w.middleRows<3>(3) = -turning(axes, q);
  // The symmetric part of (φ_1 φ_2 φ_3).
  constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  for (int row = 0; row < 6; ++row) {
    const auto [i, j] = kPairs[row];
    relation.F_phi(6 + row, 3 * (j + 1) + i) += 1.0;
    if (i != j) relation.F_phi(6 + row, 3 * (i + 1) + j) += 1.0;
  }
  relation.F.tail<6>() = relation.F_phi.bottomRows<6>() * view.phi;
  return relation;
}

Bushing::Deflection Bushing::deflection(const NodeAverage& average, const Vector12& q) const {
  const Eigen::Matrix3d R = NodeAverage::rotation(q);
  return {.u = R_PB_.transpose() * (q.head<3>() - R * average.centroid()),
          .theta = rotation_vector(R_PB_.transpose() * R * R_PB_)};
}

double Bushing::energy_J(const Deflection& deflection) const {
  Eigen::Matrix<double, 6, 1> e;
  e << deflection.u, deflection.theta;
  return 0.5 * e.dot(params_.stiffness * e);
}

/// Φ and its derivatives, one coordinate of q or of the rates after the other.
Bushing::Response Bushing::response(const NodeAverage& average, const Vector12& q,
                                    const Vector12& rate) const {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const Eigen::Matrix3d R_BP = R_PB_.transpose();
  const Eigen::Matrix3d R = NodeAverage::rotation(q);
  const Eigen::Matrix3d H = turning(R, q);
  const Eigen::Matrix3d H_inverse = H.inverse();
  const Eigen::Vector3d arm = R * average.centroid();
  const auto [u, theta] = deflection(average, q);
  const Eigen::Vector3d omega = H_inverse * sum_of_crosses(R, rate);
  Vector6 e;
  Vector6 nu;
  e << u, theta;
  nu << R_BP * (triple(rate, 0) - omega.cross(arm)), R_BP * omega;
  const Vector6 s = params_.stiffness * e;
  const Vector6 n = params_.damping * nu;
  const Eigen::Vector3d s_theta = s.tail<3>();
  const auto [b, slope] = curvature(theta.squaredNorm());
  const Eigen::Matrix3d T = cross_matrix(theta);
  const Eigen::Matrix3d J_r_inverse = Eigen::Matrix3d::Identity() + 0.5 * T + b * T * T;
  const Eigen::Vector3d F = -R_PB_ * (s.head<3>() + n.head<3>());
  const Eigen::Vector3d M = -R_PB_ * (J_r_inverse * s_theta + n.tail<3>());
  const Eigen::Vector3d tau = H_inverse * (M - arm.cross(F));

  Response result;
  result.phi.head<3>() = F;
  for (int k = 0; k < 3; ++k) result.phi.segment<3>(3 * (k + 1)) = tau.cross(R.col(k));
  for (int c = 0; c < 24; ++c) {
    const Vector12 dq = c < 12 ? Vector12(Vector12::Unit(c)) : Vector12(Vector12::Zero());
    const Vector12 d_rate = c < 12 ? Vector12(Vector12::Zero()) : Vector12(Vector12::Unit(c - 12));
    const Eigen::Vector3d alpha = H_inverse * sum_of_crosses(R, dq);
    const Eigen::Matrix3d dR = cross_matrix(alpha) * R;
    const Eigen::Matrix3d dH = turning(dR, q) + turning(R, dq);
    const Eigen::Vector3d d_arm = alpha.cross(arm);
    const Eigen::Vector3d d_omega =
        H_inverse * (sum_of_crosses(dR, rate) + sum_of_crosses(R, d_rate) - dH * omega);
    const Eigen::Vector3d d_theta = J_r_inverse.transpose() * (R_BP * alpha);
    Vector6 de;
    Vector6 d_nu;
    de << R_BP * (triple(dq, 0) - d_arm), d_theta;
    d_nu << R_BP * (triple(d_rate, 0) - d_omega.cross(arm) - omega.cross(d_arm)), R_BP * d_omega;
    const Vector6 ds = params_.stiffness * de;
    const Vector6 dn = params_.damping * d_nu;
    const Eigen::Matrix3d dT = cross_matrix(d_theta);
    const Eigen::Vector3d d_moment = J_r_inverse * ds.tail<3>() + 0.5 * dT * s_theta +
                                     b * (dT * T + T * dT) * s_theta +
                                     2.0 * slope * theta.dot(d_theta) * (T * T * s_theta);
    const Eigen::Vector3d dF = -R_PB_ * (ds.head<3>() + dn.head<3>());
    const Eigen::Vector3d dM = -R_PB_ * (d_moment + dn.tail<3>());
    const Eigen::Vector3d d_tau = H_inverse * (dM - d_arm.cross(F) - arm.cross(dF) - dH * tau);
    Vector12 d_phi;
    d_phi.head<3>() = dF;
    for (int k = 0; k < 3; ++k) {
      d_phi.segment<3>(3 * (k + 1)) = d_tau.cross(R.col(k)) + tau.cross(dR.col(k));
    }
    if (c < 12) {
      result.phi_q.col(c) = d_phi;
    } else {
      result.phi_rate.col(c - 12) = d_phi;
    }
  }
  return result;
}

PortRelation Bushing::relation(const NodeAverage& average, const PortView& view) const {
  const Matrix12 spin = four_times(cross_matrix(view.w));
  const Response answer = response(average, view.q, view.u - spin * view.q);
  PortRelation relation{.F = view.phi - answer.phi,
                        .F_q = -answer.phi_q + answer.phi_rate * spin,
                        .F_u = -answer.phi_rate,
                        .F_w = Eigen::Matrix<double, 12, 3>::Zero(),
                        .F_phi = Matrix12::Identity()};
  for (int j = 0; j < 4; ++j) {
    relation.F_w -= answer.phi_rate.middleCols<3>(3 * j) * cross_matrix(triple(view.q, j));
  }
  return relation;
}

}  // namespace tandem::fem
