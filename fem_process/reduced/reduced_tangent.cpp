#include "fem_process/reduced/reduced_tangent.h"

#include <utility>

#include "fem_process/kernels/cross_matrix.h"

namespace tandem::fem {
namespace {

/// Accelerations that a change of the velocities and of the affine map makes.
FieldMotion acceleration_change(const ReducedModel& reduced, const StepMap& map, StepMap change,
                                const FieldMotion& V) {
  change.c_a = map.c_a;
  change.c_a_prescribed = map.c_a_prescribed;
  return acceleration(reduced, change, V);
}

/// The derivative of a state that does not depend on the input.
State at_rest(Eigen::Index size, const Integrator& integrator) {
  State zero;
  zero.x = zero.v = Eigen::VectorXd::Zero(size);
  if (integrator.keeps_history()) zero.a = zero.a_mean = zero.acceleration = zero.x;
  return zero;
}

/// [force; moment; forces on ζ] of unchanged forces when the placement they act at changes.
Eigen::VectorXd placement_change(const ReducedModel& reduced, const FieldMotion& dY,
                                 const Eigen::Matrix3d& dR, const FieldMotion& G) {
  Eigen::VectorXd Q = generalised_forces(reduced, dY, dR, G);
  Q.head<3>().setZero();
  return Q;
}

}  // namespace

/// Derivatives before the solve: modal velocities unchanged.
void ReducedTangent::place(const ReducedState& before, const MotionDerivative& motions,
                           const ReducedStep::Result& result, Eigen::Index column,
                           Direction& direction) const {
  const FloatingFrame& frame = reduced_.frame();
  const Integrator& integrator = *reduced_.model().integrator;
  const auto parts = static_cast<Eigen::Index>(frame.parts());
  const bool started = direction.begin.fields.v.size() > 0;
  direction.at_begin = std::move(direction.at_end);
  if (!started) {
    direction.at_begin = frame.change(result.begin, Eigen::VectorXd::Zero(12 * parts));
    direction.begin.modal = at_rest(reduced_.modes(), integrator);
    direction.begin.fields = at_rest(3 * reduced_.fields(), integrator);
  }
  Eigen::VectorXd change = Eigen::VectorXd::Zero(12 * parts);
  const Eigen::Index port = column / 12;
  change.segment<12>(12 * port) = motions[static_cast<std::size_t>(port)].col(column % 12);
  direction.at_end = frame.change(result.end, change);
  const Eigen::Index m = reduced_.modes();
  direction.modal_map = integrator.map(direction.begin.modal, result.h_s);
  if (started && integrator.keeps_history()) {
    direction.turn = reduced_turn_change(
        integrator, before.fields, result.Y_begin, result.begin.w_WF, result.h_s,
        {direction.begin.fields, direction.Y, direction.at_begin.w_WF});
  } else {
    direction.turn = {.fields = direction.begin.fields,
                      .map = integrator.map(direction.begin.fields, result.h_s),
                      .carried = FieldMotion::Zero(3, reduced_.fields())};
  }
  direction.field_map = direction.turn.map;
  direction.eta_hat = direction.modal_map.x_tilde + direction.modal_map.d_hat;
  const auto& at = result.end;
  const auto& to = direction.at_end;
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  const Eigen::Matrix3d R_dot = cross_matrix(at.w_WF) * at.R_WF;
  const Eigen::Matrix3d dR_dot = cross_matrix(to.w_WF) * at.R_WF + cross_matrix(at.w_WF) * to.R_WF;
  const Eigen::VectorXd z_dot = joined(at.z_dot, result.state.modal.v);
  direction.V =
      ReducedModel::fields_of(to.v_WF, dR_dot, 1.0, result.state.z) +
      ReducedModel::fields_of(none, R_dot, 0.0, joined(to.z, direction.eta_hat)) +
      ReducedModel::fields_of(none, to.R_WF, 0.0, z_dot) +
      ReducedModel::fields_of(none, at.R_WF, 0.0, joined(to.z_dot, Eigen::VectorXd::Zero(m)));
}

/// Wrench derivatives of one direction, and the derivative of the new state.
void ReducedTangent::finish(const ReducedStep::Result& result, FieldMotion inertia,
                            const FieldMotion& momentum, const Eigen::VectorXd& eta_dot,
                            Eigen::Index column, Direction& direction) {
  const Model& model = reduced_.model();
  const Integrator& integrator = *model.integrator;
  const Damping damping = damping_of(model);
  const auto& to = direction.at_end;
  const Eigen::VectorXd eta = direction.eta_hat + result.modal_map.c_x * eta_dot;
  const FieldMotion dY_begin =
      direction.Y.size() > 0 ? direction.Y : FieldMotion::Zero(3, reduced_.fields());
  direction.Y =
      ReducedModel::fields_of(to.p_WF, to.R_WF, 1.0, result.state.z) +
      ReducedModel::fields_of(Eigen::Vector3d::Zero(), result.end.R_WF, 0.0, joined(to.z, eta));
  const Eigen::VectorXd elastic = reduced_.K_boundary() * (to.z + damping.beta_s * to.z_dot);
  const bool at_begin = integrator.constant_forces();
  const auto& pose = at_begin ? result.begin : result.end;
  const auto& d_pose = at_begin ? direction.at_begin : to;
  const FieldMotion& Y = at_begin ? result.Y_begin : result.Y;
  Eigen::VectorXd dQ =
      generalised_forces(reduced_, Y, pose.R_WF, inertia + damping.alpha_per_s * momentum) +
      placement_change(reduced_, at_begin ? dY_begin : direction.Y, d_pose.R_WF, result.balance);
  dQ.tail(elastic.size()) += elastic;
  if (at_begin) {
    dQ.segment<3>(3) += (moment(direction.Y - dY_begin, result.momentum) +
                         moment(result.Y - result.Y_begin, momentum)) /
                        result.h_s;
  }
  ReducedState after;
  const Eigen::VectorXd react =
      pose.jacobian.transpose() * dQ + d_pose.jacobian.transpose() * result.generalised;
  jacobian_.col(column) = -react.head(jacobian_.rows());

  const auto& map = result.modal_map;
  keep(integrator, direction.begin.modal, eta, eta_dot,
       direction.modal_map.a_hat + map.c_a * eta_dot, result.h_s, after.modal);
  keep_turning(integrator, direction.turn, flat(direction.Y), flat(direction.V),
               acceleration_change(reduced_, result.field_map, direction.field_map, direction.V),
               result.h_s, after.fields);
  direction.begin = std::move(after);
}

void ReducedTangent::advance(const ReducedState& before, const MotionDerivative& motions,
                             const ReducedStep::Result& result) {
  const Eigen::Index columns = 12 * static_cast<Eigen::Index>(result.state.ports.size());
  const Eigen::Index m = reduced_.modes();
  const Eigen::Index K = reduced_.fields();
  const auto& at = result.end;
  directions_.resize(static_cast<std::size_t>(columns));
  jacobian_.setZero(columns / 2, columns);
  // One product with the large matrix T for all directions.
  Eigen::MatrixXd stacked(6 * columns, K);
  for (Eigen::Index c = 0; c < columns; ++c) {
    Direction& direction = directions_[static_cast<std::size_t>(c)];
    place(before, motions, result, c, direction);
    stacked.middleRows<3>(6 * c) =
        acceleration_change(reduced_, result.field_map, direction.field_map, direction.V);
    stacked.middleRows<3>(6 * c + 3) = direction.V;
  }
  const Eigen::MatrixXd weighed = stacked * reduced_.T();
  const Eigen::Matrix3d response = at.R_WF + result.modal_map.c_x * cross_matrix(at.w_WF) * at.R_WF;
  const double damping = damping_of(reduced_.model()).alpha_per_s;
  for (Eigen::Index c = 0; c < columns; ++c) {
    Direction& direction = directions_[static_cast<std::size_t>(c)];
    FieldMotion inertia = weighed.middleRows<3>(6 * c);
    FieldMotion momentum = weighed.middleRows<3>(6 * c + 3);
    Eigen::VectorXd eta_dot = Eigen::VectorXd::Zero(m);
    if (m > 0) {
      const Eigen::VectorXd residual =
          modal_forces(reduced_, direction.at_end.R_WF, result.balance) +
          modal_forces(reduced_, at.R_WF, inertia + damping * momentum) +
          reduced_.omega2().cwiseProduct(direction.eta_hat);
      eta_dot = -result.lu.solve(residual);
      const FieldMotion change =
          ReducedModel::fields_of(Eigen::Vector3d::Zero(), response, 0.0, eta_dot).rightCols(3 * m);
      const FieldMotion more = change * reduced_.T().bottomRows(3 * m);
      direction.V.rightCols(3 * m) += change;
      inertia += result.field_map.c_a * more;
      momentum += more;
    }
    finish(result, std::move(inertia), momentum, eta_dot, c, direction);
  }
}

}  // namespace tandem::fem
