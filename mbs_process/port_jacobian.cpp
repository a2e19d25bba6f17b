#include "mbs_process/port_jacobian.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "protocol/contract/port.h"

namespace tandem::mbs {
namespace {

constexpr double kProbeMotion = 1e-6;

Motion motion_of(const BodyState& body) {
  return {.p_WP = body.p_WB, .q_WP = body.q_WB, .v_WP = body.v_WB, .w_WP = body.w_WB};
}

}  // namespace

ProbeSizes probe_sizes(const BodyParams& body, const Eigen::Vector3d& p_BP, double macro_step_s) {
  const Eigen::Matrix3d inertia = body.inertia_B();
  const double smallest =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly)
          .eigenvalues()[0];
  const double acceleration = kProbeMotion / (macro_step_s * macro_step_s);
  return {.force_N = acceleration / (1.0 / body.mass_kg + p_BP.squaredNorm() / smallest),
          .torque_Nm = acceleration * inertia.trace() / 3.0};
}

Eigen::Matrix<double, 12, 1> port_derivative(const BodyState& base, const BodyState& probed,
                                             const Eigen::Vector3d& p_BP, double delta) {
  const Eigen::VectorXd body = difference({motion_of(base)}, {motion_of(probed)}) / delta;
  const Eigen::Vector3d dtheta = body.segment<3>(3);
  const Eigen::Vector3d dw = body.segment<3>(9);
  const Eigen::Vector3d r = base.q_WB * p_BP;
  Eigen::Matrix<double, 12, 1> column;
  column.segment<3>(0) = body.segment<3>(0) + dtheta.cross(r);
  column.segment<3>(3) = dtheta;
  column.segment<3>(6) = body.segment<3>(6) + dw.cross(r) + base.w_WB.cross(dtheta.cross(r));
  column.segment<3>(9) = dw;
  return column;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& r) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -r.z(), r.y(),  //
      r.z(), 0.0, -r.x(),        //
      -r.y(), r.x(), 0.0;
  return matrix;
}

Eigen::Matrix3d turn_by_rate(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  const Eigen::Matrix3d cross = cross_matrix(turn);
  // Where the series' next term is below round-off: φ⁴/720 and φ⁴/5040 at 1e-3.
  const bool small = angle < 1e-3;
  const double a2 = angle * angle;
  const double half_sine = std::sin(0.5 * angle);
  const double first = small ? 0.5 - a2 / 24.0 : 2.0 * half_sine * half_sine / a2;
  const double second = small ? 1.0 / 6.0 - a2 / 120.0 : (angle - std::sin(angle)) / (a2 * angle);
  return Eigen::Matrix3d::Identity() + first * cross + second * cross * cross;
}

Eigen::Matrix<double, 12, 6> port_change_by_twist(const BodyState& end, const Eigen::Vector3d& p_BP,
                                                  double h_s) {
  const Eigen::Matrix3d arm = cross_matrix(end.q_WB * p_BP);
  const Eigen::Matrix3d turn = h_s * turn_by_rate(h_s * end.w_WB);
  Eigen::Matrix<double, 12, 6> change = Eigen::Matrix<double, 12, 6>::Zero();
  change.block<3, 3>(0, 0) = h_s * Eigen::Matrix3d::Identity();
  change.block<3, 3>(0, 3) = -arm * turn;
  change.block<3, 3>(3, 3) = turn;
  change.block<3, 3>(6, 0).setIdentity();
  change.block<3, 3>(6, 3) = -arm - cross_matrix(end.w_WB) * arm * turn;
  change.block<3, 3>(9, 3).setIdentity();
  return change;
}

}  // namespace tandem::mbs
