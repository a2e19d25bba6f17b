#include "fem_process/ports/floating_frame.h"

#include <utility>

#include "fem_process/kernels/cross_matrix.h"

namespace tandem::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

/// ½ a ∘ q: the change of q when it turns by the small vector a.
Quaterniond turned(const Vector3d& a, const Quaterniond& q) {
  Quaterniond result = Quaterniond(0.0, a.x(), a.y(), a.z()) * q;
  result.coeffs() *= 0.5;
  return result;
}

Quaterniond quaternion(const Eigen::Vector4d& coefficients) { return Quaterniond(coefficients); }

/// s I − [r]× of a quaternion (s, r): vec(a ∘ (s, r)) = that times a.
Matrix3d left_matrix(const Quaterniond& q) {
  return q.w() * Matrix3d::Identity() - cross_matrix(q.vec());
}

/// q_WF* q_b with a scalar part that is not negative.
Quaterniond relative(const Quaterniond& q_WF, const Quaterniond& q_b) {
  Quaterniond relative = q_WF.conjugate() * q_b;
  if (relative.w() < 0.0) relative.coeffs() *= -1.0;
  return relative;
}

}  // namespace

FloatingFrame::FloatingFrame(MotionSet begin, std::vector<double> weights, const Vector3d& still)
    : begin_(std::move(begin)), weights_(std::move(weights)), X_F_(Vector3d::Zero()) {
  double sum = 0.0;
  for (std::size_t b = 0; b < begin_.size(); ++b) {
    X_F_ += weights_[b] * begin_[b].p_WP;
    sum += weights_[b];
  }
  if (sum == 0.0) X_F_ = still;
}

Matrix3d FloatingFrame::share(const Placement& at, std::size_t b) const {
  // One carrier: without a rounding, which inertia would magnify by the mass over the step.
  if (weights_[b] == 1.0) return Matrix3d::Identity();
  return weights_[b] / at.Q.squaredNorm() * left_matrix(at.q[b] * quaternion(at.Q).conjugate());
}

FloatingFrame::Placement FloatingFrame::place(const MotionSet& motions) const {
  const std::size_t n = begin_.size();
  const auto rows = 6 * static_cast<Eigen::Index>(n);
  Placement at;
  at.p_WF = X_F_;
  at.twists.resize(rows);
  bool carried = false;
  for (std::size_t b = 0; b < n; ++b) {
    Quaterniond q = motions[b].q_WP * begin_[b].q_WP.conjugate();
    // q and −q are one rotation: the sign that adds up.
    if (carried && at.Q.dot(q.coeffs()) < 0.0) q.coeffs() *= -1.0;
    at.Q += weights_[b] * q.coeffs();
    carried = carried || weights_[b] > 0.0;
    at.q.push_back(q);
    at.p_WF += weights_[b] * (motions[b].p_WP - begin_[b].p_WP);
    at.twists.segment<3>(6 * static_cast<Eigen::Index>(b)) = motions[b].v_WP;
    at.twists.segment<3>(6 * static_cast<Eigen::Index>(b) + 3) = motions[b].w_WP;
  }
  if (!carried) at.Q = Quaterniond::Identity().coeffs();
  const Quaterniond q_WF = quaternion(at.Q).normalized();
  at.R_WF = q_WF.toRotationMatrix();
  const Matrix3d R_FW = at.R_WF.transpose();
  at.z.resize(rows);
  at.jacobian = Eigen::MatrixXd::Zero(rows + 6, rows);
  std::vector<Matrix3d> D;
  for (std::size_t b = 0; b < n; ++b) {
    const auto column = 6 * static_cast<Eigen::Index>(b);
    D.push_back(share(at, b));
    at.jacobian.block<3, 3>(0, column).diagonal().setConstant(weights_[b]);
    at.jacobian.block<3, 3>(3, column + 3) = D[b];
  }
  for (std::size_t a = 0; a < n; ++a) {
    const auto row = 6 + 6 * static_cast<Eigen::Index>(a);
    at.arm.push_back(motions[a].p_WP - at.p_WF);
    const Quaterniond q_Fa = relative(q_WF, at.q[a]);
    if (q_Fa.w() < at.least_cosine) {
      at.least_cosine = q_Fa.w();
      at.turned_most = static_cast<int>(a);
    }
    at.z.segment<3>(row - 6) = R_FW * at.arm[a] - (begin_[a].p_WP - X_F_);
    at.z.segment<3>(row - 3) = 2.0 * q_Fa.vec();
    const Matrix3d N = left_matrix(q_Fa) * R_FW;
    for (std::size_t b = 0; b < n; ++b) {
      const auto column = 6 * static_cast<Eigen::Index>(b);
      const double own = a == b ? 1.0 : 0.0;
      at.jacobian.block<3, 3>(row, column) = (own - weights_[b]) * R_FW;
      at.jacobian.block<3, 3>(row, column + 3) = R_FW * cross_matrix(at.arm[a]) * D[b];
      at.jacobian.block<3, 3>(row + 3, column + 3) = N * (own * Matrix3d::Identity() - D[b]);
    }
  }
  const Eigen::VectorXd rates = at.jacobian * at.twists;
  at.v_WF = rates.head<3>();
  at.w_WF = rates.segment<3>(3);
  at.z_dot = rates.tail(rows);
  return at;
}

FloatingFrame::Change FloatingFrame::change(const Placement& at,
                                            const Eigen::VectorXd& motions) const {
  const std::size_t n = begin_.size();
  const auto rows = 6 * static_cast<Eigen::Index>(n);
  Eigen::VectorXd poses(rows);
  Eigen::VectorXd twists(rows);
  Eigen::Vector4d dQ = Eigen::Vector4d::Zero();
  for (std::size_t b = 0; b < n; ++b) {
    const auto column = 6 * static_cast<Eigen::Index>(b);
    poses.segment<6>(column) = motions.segment<6>(2 * column);
    twists.segment<6>(column) = motions.segment<6>(2 * column + 6);
    dQ += weights_[b] * turned(poses.segment<3>(column + 3), at.q[b]).coeffs();
  }
  const Eigen::VectorXd moved = at.jacobian * poses;
  const Vector3d dphi = moved.segment<3>(3);
  const Quaterniond q_WF = quaternion(at.Q).normalized();
  const Matrix3d R_FW = at.R_WF.transpose();
  Change change;
  change.p_WF = moved.head<3>();
  change.R_WF = cross_matrix(dphi) * at.R_WF;
  change.z = moved.tail(rows);
  change.jacobian = Eigen::MatrixXd::Zero(rows + 6, rows);
  const Matrix3d dR_FW = change.R_WF.transpose();

  const double norm2 = at.Q.squaredNorm();
  const Quaterniond Q_conjugate = quaternion(at.Q).conjugate();
  const Quaterniond dQ_conjugate = quaternion(dQ).conjugate();
  std::vector<Matrix3d> D;
  std::vector<Matrix3d> dD;
  for (std::size_t b = 0; b < n; ++b) {
    const auto column = 6 * static_cast<Eigen::Index>(b);
    D.push_back(share(at, b));
    const Quaterniond d1 = turned(poses.segment<3>(column + 3), at.q[b]) * Q_conjugate;
    const Quaterniond d2 = at.q[b] * dQ_conjugate;
    dD.push_back(weights_[b] / norm2 * (left_matrix(d1) + left_matrix(d2)) -
                 2.0 * at.Q.dot(dQ) / norm2 * D[b]);
    change.jacobian.block<3, 3>(3, column + 3) = dD[b];
  }
  for (std::size_t a = 0; a < n; ++a) {
    const auto row = 6 + 6 * static_cast<Eigen::Index>(a);
    const Vector3d d_arm = poses.segment<3>(row - 6) - change.p_WF;
    const Quaterniond q_Fa = relative(q_WF, at.q[a]);
    const Quaterniond dq_Fa = turned(R_FW * (poses.segment<3>(row - 3) - dphi), q_Fa);
    const Matrix3d N = left_matrix(q_Fa) * R_FW;
    const Matrix3d dN = left_matrix(dq_Fa) * R_FW + left_matrix(q_Fa) * dR_FW;
    const Matrix3d lever = R_FW * cross_matrix(at.arm[a]);
    const Matrix3d d_lever = dR_FW * cross_matrix(at.arm[a]) + R_FW * cross_matrix(d_arm);
    for (std::size_t b = 0; b < n; ++b) {
      const auto column = 6 * static_cast<Eigen::Index>(b);
      const double own = a == b ? 1.0 : 0.0;
      change.jacobian.block<3, 3>(row, column) = (own - weights_[b]) * dR_FW;
      change.jacobian.block<3, 3>(row, column + 3) = d_lever * D[b] + lever * dD[b];
      change.jacobian.block<3, 3>(row + 3, column + 3) =
          dN * (own * Matrix3d::Identity() - D[b]) - N * dD[b];
    }
  }
  const Eigen::VectorXd rates = change.jacobian * at.twists + at.jacobian * twists;
  change.v_WF = rates.head<3>();
  change.w_WF = rates.segment<3>(3);
  change.z_dot = rates.tail(rows);
  return change;
}

}  // namespace tandem::fem
