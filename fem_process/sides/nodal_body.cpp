#include "fem_process/sides/nodal_body.h"

#include <fmt/format.h>

#include <utility>

#include "fem_process/reduced/highest_frequency.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

/// Both interface Jacobians are dense: with so many nodes each has 38 MB, and solving with them
/// takes a second per step.
constexpr std::size_t kMostLinearised = 256;

/// The nodes are ports of their own: none is left for a rigid frame.
Params without_rigid_ports(Params params) {
  params.ports.clear();
  return params;
}

std::string port_name(const Model& model, int node) {
  return "node_" + std::to_string(model.mesh.node_tags[static_cast<std::size_t>(node)]);
}

void check_ports(const Model& model) {
  const std::vector<SetName>& ports = model.params.node_ports;
  if (ports.empty()) return;  // asked for its masses
  bool same = ports.size() == model.free.size();
  for (std::size_t p = 0; same && p < model.free.size(); ++p) {
    same = ports[p].name == port_name(model, model.free[p]);
  }
  const scenario::Place& place = ports.front().place;
  require(same, (place.file.empty() ? "fem" : place.text()) +
                    ": ports: with fem.coupling: nodal they are made from the mesh, one for each "
                    "free node, and these are not they. Leave out ports and mbs.bodies.");
}

void check_nodal(const Model& model) {
  const Params& params = model.params;
  require(params.mass == MassKind::Lumped,
          "fem: coupling: nodal needs fem.mass: lumped, since a body of the multibody side can "
          "have no consistent mass.");
  require(params.formulation != FormulationKind::CraigBampton,
          "fem: coupling: nodal needs the nodes' own forces. Choose another fem.formulation than "
          "craig_bampton.");
  require(params.gravity_m_per_s2.isZero(0.0),
          "fem: with coupling: nodal the masses belong to the multibody side. Give gravity as "
          "mbs.gravity_m_per_s2 and leave out fem.gravity_m_per_s2.");
  require(params.integrator.kind == IntegratorKind::BackwardEuler &&
              params.integrator.newton_steps == 0 && params.follows_macro_step,
          "fem: with coupling: nodal the multibody side integrates the nodes' motion. Leave out "
          "fem.integrator and fem.micro_step_s; mbs.integrator and mbs.micro_step_s take their "
          "place.");
  require(params.changes.empty(),
          "fem: with coupling: nodal the free nodes are bodies throughout. Leave out fem.changes, "
          "or use coupling: ports.");
  check_ports(model);
}

}  // namespace

std::vector<NodeMass> node_masses(const Params& params) {
  const Model model(without_rigid_ports(params));
  check_nodal(model);
  const Eigen::VectorXd v = model.initial_velocities();
  std::vector<NodeMass> nodes;
  for (int node : model.free) {
    const int diagonal = model.pattern().find(node, node);
    nodes.push_back({.name = port_name(model, node),
                     .mass_kg = model.mass[static_cast<std::size_t>(diagonal)],
                     .position_m = model.mesh.X[static_cast<std::size_t>(node)],
                     .velocity_m_per_s = v.segment<3>(3 * node)});
  }
  return nodes;
}

NodalBody::NodalBody(Params params) : model_(without_rigid_ports(std::move(params))) {
  check_nodal(model_);
  info_.name = "fem";
  for (int node : model_.free) {
    info_.ports.push_back({port_name(model_, node), diagonal_of(model_.mesh)});
  }
  info_.micro_step = model_.params.micro_step;
  info_.can_linearize = model_.free.size() <= kMostLinearised;
}

void NodalBody::take(const MotionSet& motions, State& state) const {
  require(motions.size() == model_.free.size(), "fem: " + std::to_string(motions.size()) +
                                                    " motions for " +
                                                    std::to_string(model_.free.size()) + " nodes.");
  for (std::size_t p = 0; p < motions.size(); ++p) {
    state.x.segment<3>(3 * model_.free[p]) = motions[p].p_WP;
    state.v.segment<3>(3 * model_.free[p]) = motions[p].v_WP;
  }
}

WrenchSet NodalBody::wrenches(State& state) const {
  const Damping& damping = model_.params.damping;
  Eigen::VectorXd f_int;
  BlockValues K;
  state.inverted_elements = model_.formulation->evaluate(state.x, f_int, K);
  state.damping_force =
      multiply(model_.pattern(), K, damping.beta_s * state.v) +
      damping.alpha_per_s * multiply_scalar(model_.pattern(), model_.mass, state.v);
  const Eigen::VectorXd f = model_.loads(to_seconds(state.time)) - f_int - state.damping_force;
  WrenchSet wrenches(model_.free.size());
  for (std::size_t p = 0; p < wrenches.size(); ++p) {
    wrenches[p].f_P_W = f.segment<3>(3 * model_.free[p]);
  }
  state.port_wrenches = wrenches;
  return wrenches;
}

/// Column by column: derivatives of f_int(x) + β K(x) v along the nodes' axes, and of C v.
InterfaceJacobian NodalBody::jacobian(const State& state) const {
  const Damping& damping = model_.params.damping;
  const auto ports = static_cast<Eigen::Index>(model_.free.size());
  InterfaceJacobian jacobian = InterfaceJacobian::Zero(6 * ports, 12 * ports);
  Eigen::VectorXd f_int;
  BlockValues K;
  model_.formulation->evaluate(state.x, f_int, K);
  const Eigen::VectorXd y = damping.beta_s * state.v;
  for (Eigen::Index p = 0; p < ports; ++p) {
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::VectorXd unit = Eigen::VectorXd::Zero(state.x.size());
      unit(3 * model_.free[static_cast<std::size_t>(p)] + axis) = 1.0;
      const Eigen::VectorXd stiff = model_.formulation->derivative(state.x, y, unit);
      const Eigen::VectorXd damped =
          multiply(model_.pattern(), K, damping.beta_s * unit) +
          damping.alpha_per_s * multiply_scalar(model_.pattern(), model_.mass, unit);
      for (Eigen::Index q = 0; q < ports; ++q) {
        const Eigen::Index at = 3 * model_.free[static_cast<std::size_t>(q)];
        jacobian.block<3, 1>(6 * q, 12 * p + axis) = -stiff.segment<3>(at);
        jacobian.block<3, 1>(6 * q, 12 * p + 6 + axis) = -damped.segment<3>(at);
      }
    }
  }
  return jacobian;
}

WrenchSet NodalBody::initialize(const MotionSet& motions) {
  require(all_finite(motions), "fem: initialize: the port motions must be finite.");
  state_ = State{};
  state_.x = model_.reference();
  state_.v = Eigen::VectorXd::Zero(state_.x.size());
  take(motions, state_);
  WrenchSet result = wrenches(state_);
  saved_ = state_;
  return result;
}

StepResult<WrenchSet> NodalBody::advance(const StepRequest<MotionSet>& request) {
  require(state_.x.size() > 0, "fem: advance before initialize.");
  const double begin_s = now_s();
  State end = state_;
  end.time += request.step;
  StepResult<WrenchSet> result;
  if (all_finite(request.input.end)) {
    take(request.input.end, end);
    result.output = wrenches(end);
  }
  if (result.output.empty() || !all_finite(result.output)) {
    result.message = fmt::format(
        "fem: at t = {:.9g} s: the nodes' motions or forces are not finite. An explicit coupling "
        "of nodes is stable at rest for run.macro_step_s below {:.3g} s: shorten the step, or "
        "choose coupling.scheme: interface_jacobian.",
        to_seconds(end.time), explicit_step_limit_s(model_));
    return result;
  }
  result.outcome = Outcome::Done;
  result.message.clear();
  if (request.linearize && info_.can_linearize) result.jacobian = jacobian(end);
  book(state_, end);
  state_ = std::move(end);
  result.cost.compute_s = now_s() - begin_s;
  return result;
}

/// Works are trapezoids over the displacement. Without masses and equations nothing is lost.
void NodalBody::book(const State& begin, State& end) const {
  const Eigen::VectorXd moved = end.x - begin.x;
  const Eigen::VectorXd loads =
      model_.loads(to_seconds(begin.time)) + model_.loads(to_seconds(end.time));
  double interface_J = 0.0;
  for (std::size_t p = 0; p < model_.free.size(); ++p) {
    const Eigen::Vector3d f = begin.port_wrenches[p].f_P_W + end.port_wrenches[p].f_P_W;
    interface_J -= 0.5 * f.dot(moved.segment<3>(3 * model_.free[p]));
  }
  end.book.external_work_J += 0.5 * loads.dot(moved);
  end.book.interface_work_J += interface_J;
  end.book.damping_loss_J += 0.5 * moved.dot(begin.damping_force + end.damping_force);
}

void NodalBody::checkpoint() {
  saved_ = state_;
  if (observer_) observer_(state_);
}

Observation NodalBody::observe() {
  Observation seen;
  seen.time = state_.time;
  seen.state_hash = state_.hash();
  seen.energy = state_.book;
  seen.energy.elastic_J = model_.formulation->energy(state_.x);
  return seen;
}

}  // namespace tandem::fem
