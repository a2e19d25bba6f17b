#include "mbs_process/port_jacobian.h"

#include <Eigen/Eigenvalues>

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

}  // namespace tandem::mbs
