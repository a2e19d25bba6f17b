#include "mbs_process/step_work.h"

#include <Eigen/LU>

namespace tandem::mbs {
namespace {

Eigen::Matrix3d inertia_W(const BodyParams& body, const Eigen::Quaterniond& q_WB) {
  const Eigen::Matrix3d R_WB = q_WB.toRotationMatrix();
  return R_WB * body.inertia_B() * R_WB.transpose();
}

}  // namespace

void SortedWrenches::reset(std::size_t bodies) {
  for (auto* wrenches : {&driven, &viscous, &elastic, &ports, &gyroscopic, &motors, &joints}) {
    wrenches->assign(bodies, BodyWrench{});
  }
}

double work_J(const std::vector<BodyWrench>& wrenches, const std::vector<BodyState>& moving,
              double h_s) {
  double power_W = 0.0;
  for (std::size_t i = 0; i < wrenches.size(); ++i) {
    power_W += wrenches[i].f_B_W.dot(moving[i].v_WB) + wrenches[i].t_B_W.dot(moving[i].w_WB);
  }
  return h_s * power_W;
}

double velocity_change_J(const Params& params, const std::vector<BodyState>& a,
                         const std::vector<BodyState>& b) {
  double energy_J = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (params.bodies[i].massless) continue;
    const Eigen::Vector3d w_B = a[i].q_WB.conjugate() * (b[i].w_WB - a[i].w_WB);
    energy_J += 0.5 * (params.bodies[i].mass_kg * (b[i].v_WB - a[i].v_WB).squaredNorm() +
                       w_B.dot(params.bodies[i].inertia_B() * w_B));
  }
  return energy_J;
}

double stand_in_work_J(const Params& params, const std::vector<BodyState>& a,
                       const std::vector<BodyState>& b, const std::vector<BodyState>& moving) {
  double work_J = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const BodyParams& body = params.bodies[i];
    if (!body.massless) continue;
    work_J += body.mass_kg * (b[i].v_WB - a[i].v_WB).dot(moving[i].v_WB) +
              body.inertia_kg_m2[0] * (b[i].w_WB - a[i].w_WB).dot(moving[i].w_WB);
  }
  return work_J;
}

Eigen::Vector3d implicit_gyroscopic_torque(const BodyParams& body, const BodyState& state,
                                           double h_s) {
  const Eigen::Matrix3d I = inertia_W(body, state.q_WB);
  const Eigen::Vector3d L = I * state.w_WB;
  // w̃ × L = −L× w̃
  Eigen::Matrix3d matrix = I;
  matrix(0, 1) += h_s * L.z();
  matrix(0, 2) -= h_s * L.y();
  matrix(1, 0) -= h_s * L.z();
  matrix(1, 2) += h_s * L.x();
  matrix(2, 0) += h_s * L.y();
  matrix(2, 1) -= h_s * L.x();
  return (I * (matrix.inverse() * L) - L) / h_s;
}

void StepWork::add(const SortedWrenches& wrenches, const std::vector<BodyState>& moving, double h_s,
                   double share) {
  driven_J += work_J(wrenches.driven, moving, share * h_s);
  viscous_J += work_J(wrenches.viscous, moving, share * h_s);
  elastic_J += work_J(wrenches.elastic, moving, share * h_s);
  ports_J += work_J(wrenches.ports, moving, share * h_s);
  gyroscopic_J += work_J(wrenches.gyroscopic, moving, share * h_s);
  reactions_J += work_J(wrenches.motors, moving, h_s) + work_J(wrenches.joints, moving, h_s);
}

void StepWork::book(EnergyBook& book) const {
  book.external_work_J += driven_J + motors_J;
  book.interface_work_J += interface_J - stand_in_J;
  book.damping_loss_J -= viscous_J;
  book.numerical_loss_J += kinetic_loss_J - gyroscopic_J - (elastic_J + stored_change_J) -
                           (reactions_J - motors_J) + (interface_J - ports_J);
}

}  // namespace tandem::mbs
