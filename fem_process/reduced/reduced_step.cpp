#include "fem_process/reduced/reduced_step.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>

#include "fem_process/kernels/cross_matrix.h"
#include "fem_process/reduced/reduced_energy.h"

namespace tandem::fem {
namespace {

/// A part may turn against the frame by 120° at most: small deformations are long left by then.
constexpr double kLeastCosine = 0.5;

SolveReport check_turning(const Model& model, const FloatingFrame::Placement& at) {
  if (at.least_cosine >= kLeastCosine) return {};
  const auto part = static_cast<std::size_t>(at.turned_most);
  const std::string name =
      part < model.ports.size() ? "the port '" + model.ports[part].name + "'" : "the fixed nodes";
  return {.outcome = Outcome::Failed,
          .message = name + " turned by " +
                     fmt::format("{:.6g}", 2.0 * std::acos(at.least_cosine) * 180.0 / M_PI) +
                     "° against the floating frame, limit 120°. Craig-Bampton is for small "
                     "deformations: choose fem.formulation: corotational, or another "
                     "fem.craig_bampton.frame."};
}

/// Σ_k Ω_k C_k: the modes' Coriolis coupling.
Eigen::MatrixXd coriolis(const ReducedModel& reduced, const Eigen::Vector3d& w_F) {
  const auto& C = reduced.coriolis();
  return w_F.x() * C[0] + w_F.y() * C[1] + w_F.z() * C[2];
}

}  // namespace

std::uint64_t ReducedState::hash() const {
  StateHash hash;
  hash.add(static_cast<std::int64_t>(time.count()));
  for (const State* part : {&modal, &fields}) {
    hash.add(static_cast<std::int64_t>(part->hash()));
  }
  hash.add(std::span<const double>(z.data(), static_cast<std::size_t>(z.size())));
  for (const Motion& motion : ports) {
    for (double value : motion.p_WP) hash.add(value);
    for (double value : motion.q_WP.coeffs()) hash.add(value);
  }
  for (double work :
       {book.external_work_J, book.interface_work_J, book.damping_loss_J, book.numerical_loss_J}) {
    hash.add(work);
  }
  return hash.value();
}

Eigen::VectorXd flat(const FieldMotion& motion) {
  return Eigen::Map<const Eigen::VectorXd>(motion.data(), motion.size());
}

Eigen::VectorXd joined(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  Eigen::VectorXd whole(a.size() + b.size());
  whole << a, b;
  return whole;
}

Damping damping_of(const Model& model) {
  return model.integrator->inertia() ? model.params.damping : Damping{};
}

void keep(const Integrator& integrator, const State& begin, Eigen::VectorXd x, Eigen::VectorXd v,
          const Eigen::VectorXd& a, double h_s, State& after) {
  integrator.keep(begin, v, a, h_s, after);
  after.x = std::move(x);
  after.v = std::move(v);
}

void keep_turning(const Integrator& integrator, const ReducedTurn& turn, Eigen::VectorXd x,
                  Eigen::VectorXd v, const FieldMotion& A, double h_s, State& after) {
  const FieldMotion beyond = A - turn.carried;
  keep(integrator, turn.fields, std::move(x), std::move(v), flat(beyond), h_s, after);
  if (!integrator.keeps_history()) return;
  after.a += flat(turn.carried);
  if (after.acceleration.size() > 0) after.acceleration += flat(turn.carried);
}

FieldMotion acceleration(const ReducedModel& reduced, const StepMap& map, const FieldMotion& V) {
  if (!reduced.model().integrator->inertia()) return FieldMotion::Zero(3, V.cols());
  const Eigen::Index first = first_modal_field(reduced);
  const Eigen::Index rest = V.cols() - first;
  const Eigen::Map<const FieldMotion> prescribed(map.a_hat_prescribed.data(), 3, V.cols());
  const Eigen::Map<const FieldMotion> free(map.a_hat.data(), 3, V.cols());
  FieldMotion A(3, V.cols());
  // Differences of velocities before the division by the step: rounded once, at their own size.
  A.leftCols(first) =
      map.c_a_prescribed * (V.leftCols(first) + prescribed.leftCols(first) / map.c_a_prescribed);
  A.rightCols(rest) = map.c_a * (V.rightCols(rest) + free.rightCols(rest) / map.c_a);
  return A;
}

Eigen::VectorXd modal_forces(const ReducedModel& reduced, const Eigen::Matrix3d& R,
                             const FieldMotion& G) {
  const Eigen::Index first = first_modal_field(reduced);
  Eigen::VectorXd Q(reduced.modes());
  for (Eigen::Index c = 0; c < Q.size(); ++c) {
    Q(c) = R.cwiseProduct(G.middleCols<3>(first + 3 * c)).sum();
  }
  return Q;
}

Eigen::Vector3d moment(const FieldMotion& a, const FieldMotion& b) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index c = 0; c < a.cols(); ++c) sum += a.col(c).cross(b.col(c));
  return sum;
}

Eigen::VectorXd generalised_forces(const ReducedModel& reduced, const FieldMotion& Y,
                                   const Eigen::Matrix3d& R, const FieldMotion& G) {
  const Eigen::Index n = reduced.boundary();
  Eigen::VectorXd Q(6 + n);
  Q.head<3>() = G.col(0);
  Q.segment<3>(3) = moment(Y.rightCols(Y.cols() - 1), G.rightCols(G.cols() - 1));
  for (Eigen::Index c = 0; c < n; ++c) {
    Q(6 + c) = R.cwiseProduct(G.middleCols<3>(4 + 3 * c)).sum();
  }
  return Q;
}

WrenchSet wrenches_of(const Eigen::VectorXd& react, std::size_t ports) {
  return unstack_wrenches(-react.head(6 * static_cast<Eigen::Index>(ports)));
}

FieldMotion ReducedStep::velocity(const FloatingFrame::Placement& at, const Eigen::VectorXd& eta,
                                  const Eigen::VectorXd& eta_dot) const {
  const Eigen::Matrix3d R_dot = cross_matrix(at.w_WF) * at.R_WF;
  return ReducedModel::fields_of(at.v_WF, R_dot, 1.0, joined(at.z, eta)) +
         ReducedModel::fields_of(Eigen::Vector3d::Zero(), at.R_WF, 0.0, joined(at.z_dot, eta_dot));
}

/// Without modal accelerations, ports at constant twist: the change of all velocities as the poses
/// move on.
FieldMotion ReducedStep::drift(const FloatingFrame::Placement& at,
                               const Eigen::VectorXd& eta_dot) const {
  Eigen::VectorXd moving = Eigen::VectorXd::Zero(2 * at.twists.size());
  for (Eigen::Index b = 0; b < at.twists.size(); b += 6) {
    moving.segment<6>(2 * b) = at.twists.segment<6>(b);
  }
  const auto change = reduced_.frame().change(at, moving);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(eta_dot.size());
  const Eigen::Matrix3d turning = cross_matrix(at.w_WF);
  const Eigen::Matrix3d R_dotdot = cross_matrix(change.w_WF) * at.R_WF + turning * change.R_WF;
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  return ReducedModel::fields_of(change.v_WF, R_dotdot, 1.0, joined(at.z, zero)) +
         ReducedModel::fields_of(none, 2.0 * turning * at.R_WF, 0.0, joined(at.z_dot, eta_dot)) +
         ReducedModel::fields_of(none, at.R_WF, 0.0, joined(change.z_dot, zero));
}

void ReducedStep::start(const MotionSet& ports, ReducedState& state, WrenchSet& wrenches) const {
  const Model& model = reduced_.model();
  const Integrator& integrator = *model.integrator;
  const Damping damping = damping_of(model);
  const auto at = reduced_.frame().place(reduced_.with_ground(ports));
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(reduced_.modes());
  const FieldMotion external = reduced_.external_forces(0.0);
  Eigen::VectorXd eta = zero;
  Eigen::VectorXd eta_dot = zero;
  if (integrator.inertia()) {
    // Boundary nodes have their parts' velocities already; the modes take what the others lack.
    Eigen::VectorXd lacking =
        model.initial_velocities() - reduced_.expand(velocity(at, zero, zero));
    for (int node : model.prescribed) lacking.segment<3>(3 * node).setZero();
    eta_dot = reduced_.project(lacking);
  } else {
    eta = modal_forces(reduced_, at.R_WF, external).cwiseQuotient(reduced_.omega2());
  }
  state.ports = ports;
  state.modal.x = eta;
  state.modal.v = eta_dot;
  state.z = joined(at.z, eta);
  const FieldMotion Y = ReducedModel::fields_of(at.p_WF, at.R_WF, 1.0, state.z);
  const FieldMotion V = velocity(at, eta, eta_dot);
  const FieldMotion force = damping.alpha_per_s * V * reduced_.T() - external;
  FieldMotion A = FieldMotion::Zero(3, reduced_.fields());
  Eigen::VectorXd eta_dotdot = zero;
  if (integrator.inertia()) {
    A = drift(at, eta_dot);
    eta_dotdot = -modal_forces(reduced_, at.R_WF, A * reduced_.T() + force) -
                 damping.beta_s * reduced_.omega2().cwiseProduct(eta_dot);
    A += ReducedModel::fields_of(Eigen::Vector3d::Zero(), at.R_WF, 0.0,
                                 joined(Eigen::VectorXd::Zero(at.z.size()), eta_dotdot));
  }
  const FieldMotion inertia = A * reduced_.T();
  Eigen::VectorXd Q = generalised_forces(reduced_, Y, at.R_WF, inertia + force);
  Q.tail(at.z.size()) += reduced_.K_boundary() * (at.z + damping.beta_s * at.z_dot);
  wrenches = wrenches_of(at.jacobian.transpose() * Q, ports.size());
  state.wrenches = wrenches;
  state.fields.x = flat(Y);
  state.fields.v = flat(V);
  if (integrator.keeps_history()) {
    state.modal.a = state.modal.a_mean = state.modal.acceleration = eta_dotdot;
    state.fields.a = state.fields.a_mean = state.fields.acceleration = flat(A);
  }
}

/// The modal velocities: residual at zero, matrix, solution; fills z, V and the balance.
void ReducedStep::solve(const ReducedState& begin, const FieldMotion& external,
                        Result& result) const {
  const Damping damping = damping_of(reduced_.model());
  const auto& at = result.end;
  const StepMap& map = result.modal_map;
  const Eigen::Index m = reduced_.modes();
  const Eigen::VectorXd eta_hat = map.x_tilde + map.d_hat;
  FieldMotion inertia;
  const auto balance = [&](const FieldMotion& V) -> FieldMotion {
    inertia = acceleration(reduced_, result.field_map, V) * reduced_.T();
    return inertia + damping.alpha_per_s * V * reduced_.T() - external;
  };
  // From the last modal velocities: the less is left to correct, the less round-off.
  Eigen::VectorXd eta_dot = begin.modal.v;
  Eigen::VectorXd eta = eta_hat + map.c_x * eta_dot;
  result.V = velocity(at, eta, eta_dot);
  if (m > 0) {
    const Eigen::VectorXd residual = modal_forces(reduced_, at.R_WF, balance(result.V)) +
                                     reduced_.omega2().cwiseProduct(eta + damping.beta_s * eta_dot);
    const Eigen::Vector3d w_F = at.R_WF.transpose() * at.w_WF;
    const double scale = result.field_map.c_a + damping.alpha_per_s;
    Eigen::MatrixXd S = scale * map.c_x * coriolis(reduced_, w_F);
    S.diagonal().array() += scale + (map.c_x + damping.beta_s) * reduced_.omega2().array();
    result.lu.compute(S);
    eta_dot -= result.lu.solve(residual);
    eta = eta_hat + map.c_x * eta_dot;
    result.V = velocity(at, eta, eta_dot);
  }
  result.balance = balance(result.V);
  result.momentum = result.V * reduced_.T();
  result.state.z = joined(at.z, eta);
  result.Y = ReducedModel::fields_of(at.p_WF, at.R_WF, 1.0, result.state.z);
  const Integrator& integrator = *reduced_.model().integrator;
  keep(integrator, begin.modal, eta, eta_dot, map.a_hat + map.c_a * eta_dot, result.h_s,
       result.state.modal);
  keep_turning(integrator, result.turn, flat(result.Y), flat(result.V),
               acceleration(reduced_, result.field_map, result.V), result.h_s, result.state.fields);
}

void ReducedStep::react(Result& result) const {
  const Model& model = reduced_.model();
  const bool at_begin = model.integrator->constant_forces();
  const auto& pose = at_begin ? result.begin : result.end;
  Eigen::VectorXd& Q = result.generalised;
  Q = generalised_forces(reduced_, at_begin ? result.Y_begin : result.Y, pose.R_WF, result.balance);
  Q.tail(result.end.z.size()) +=
      reduced_.K_boundary() * (result.end.z + damping_of(model).beta_s * result.end.z_dot);
  if (at_begin) {
    Q.segment<3>(3) += moment(result.Y - result.Y_begin, result.momentum) / result.h_s;
  }
  result.wrenches = wrenches_of(pose.jacobian.transpose() * Q, result.state.ports.size());
}

ReducedStep::Result ReducedStep::advance(const ReducedState& begin, const MotionSet& ports,
                                         SimTime h) const {
  const Model& model = reduced_.model();
  Result result;
  result.h_s = to_seconds(h);
  result.begin = reduced_.frame().place(reduced_.with_ground(begin.ports));
  result.end = reduced_.frame().place(reduced_.with_ground(ports));
  result.report = check_turning(model, result.end);
  if (result.report.outcome == Outcome::Failed) return result;
  result.modal_map = model.integrator->map(begin.modal, result.h_s);
  result.state.time = begin.time + h;
  result.state.ports = ports;
  result.Y_begin = Eigen::Map<const FieldMotion>(begin.fields.x.data(), 3, reduced_.fields());
  result.turn =
      reduced_turn(*model.integrator, begin.fields, result.Y_begin, result.begin.w_WF, result.h_s);
  result.field_map = result.turn.map;
  const double t_s = to_seconds(result.state.time);
  const FieldMotion external = reduced_.external_forces(t_s);
  solve(begin, external, result);
  react(result);
  book_step(reduced_, begin, result);
  return result;
}

}  // namespace tandem::fem
