#include <utility>

#include "fem_process/matrix/node_vectors.h"
#include "fem_process/transient/step_energy.h"
#include "fem_process/transient/step_matrix.h"
#include "fem_process/transient/transient_step.h"

/// How a body starts, and starts again when its boundary conditions have changed.
namespace tandem::fem {

SolveReport TransientStep::start(const MotionSet& motions, State& state,
                                 WrenchSet& wrenches) const {
  state.x = model_.reference();
  state.v = model_.initial_velocities();
  prescribe(motions, state.x, state.v);
  loose_.set_velocities(motions, state.v);
  state.port_motions = motions;
  state.port_rates.a_mean.setZero(3 * static_cast<Eigen::Index>(motions.size()));
  if (!model_.integrator->inertia()) return settle(motions, state, wrenches);
  if (remembers()) {
    state.past.setZero(8, 3 * static_cast<Eigen::Index>(model_.free.size()));
    remember(state.v, state);
  }
  Eigen::VectorXd a = Eigen::VectorXd::Zero(state.x.size());
  for (std::size_t p = 0; p < arms_.size(); ++p) {
    const Eigen::Vector3d& w = motions[p].w_WP;
    const Eigen::Matrix3d R_WP = motions[p].q_WP.toRotationMatrix();
    for (std::size_t k = 0; k < arms_[p].size(); ++k) {
      a.segment<3>(3 * model_.ports[p].nodes[k]) = w.cross(w.cross(R_WP * arms_[p][k]));
    }
  }
  for (const LoosePorts::Port& port : loose_.ports()) {
    const Motion& motion = motions[port.index];
    for (int node : port.average.nodes()) {
      const Eigen::Vector3d r = state.x.segment<3>(3 * node) - motion.p_WP;
      a.segment<3>(3 * node) = motion.w_WP.cross(motion.w_WP.cross(r));
    }
  }
  const Eigen::VectorXd q = loose_.coordinates(state.x);
  state.attached = loose_.bushing_forces(motions, q, loose_.coordinates(state.v));
  Eigen::VectorXd react;
  const SolveReport report = accelerate(state, a, react);
  wrenches = port_wrenches(model_, arms_, arms_at(motions), react);
  loose_.add_wrenches(arms_at(motions).about, q, state.attached, wrenches);
  state.port_wrenches = wrenches;
  state.bushing_J = loose_.energy_J(motions, q);
  state.bushing_loss_W = bushing_loss_W(loose_, motions, q, loose_.coordinates(state.v));
  if (!model_.integrator->keeps_history()) return report;
  state.rigid = loose_.rigid_start(motions);
  state.a_mean = state.a = state.acceleration = std::move(a);
  // Ports at constant twist: their origins are not accelerated.
  state.port_rates.a = state.port_rates.acceleration = state.port_rates.a_mean;
  return report;
}

/// Accelerations of the free nodes from the balance at the state's x, v and t, those of the
/// prescribed nodes and of the rigid parts of averaging ports given, the forces of bushings too;
/// the reactions and multipliers; the forces of the state where it keeps them.
SolveReport TransientStep::accelerate(State& state, Eigen::VectorXd& a,
                                      Eigen::VectorXd& react) const {
  Eigen::VectorXd f_int;
  BlockValues K;
  state.inverted_elements = model_.formulation->evaluate(state.x, f_int, K);
  const Eigen::VectorXd beyond =
      is_damped() ? Eigen::VectorXd(state.v - carry_->reference_at(state, state.port_motions))
                  : Eigen::VectorXd::Zero(state.v.size());
  const Eigen::VectorXd force = f_int + damping_force(K, state.v, beyond) -
                                model_.external_forces(to_seconds(state.time)) -
                                commanded_forces(state);
  Eigen::MatrixXd rhs(3 * static_cast<Eigen::Index>(model_.free.size()), 1 + loose_.size());
  rhs.col(0) = -gather(multiply_scalar(model_.pattern(), model_.mass, a) + force, model_.free);
  rhs.rightCols(loose_.size()) = loose_.columns();
  BlockValues M;
  combine(model_.interior, 1.0, model_.mass, 0.0, nullptr, M, *model_.team);
  const auto solver = make_solver(model_.params.solver, model_.interior.pattern);
  SolveReport report = solver->factorize(M);
  const Eigen::VectorXd norms = rhs.colwise().norm();
  if (report.outcome == Outcome::Done) report = solver->solve(rhs, norms);
  if (!loose_.empty()) {
    const Eigen::MatrixXd Y = loose_.coordinates_of(rhs.rightCols(loose_.size()));
    loose_.close_accelerations(Y, loose_.coordinates(state.x), loose_.coordinates_of(rhs.col(0)),
                               state.attached);
    rhs.col(0) += rhs.rightCols(loose_.size()) * state.attached;
  }
  scatter_add(rhs.col(0), model_.free, a);
  react = multiply_scalar(model_.pattern(), model_.mass, a) + force;
  for (int node : model_.free) react.segment<3>(3 * node).setZero();
  Eigen::VectorXd on_nodes = react;
  loose_.add_forces(state.attached, 1.0, on_nodes);
  book_start(model_, K, on_nodes, beyond, state);
  return report;
}

SolveReport TransientStep::restart(State& state) const {
  for (int node : model_.fixed) {
    for (Eigen::VectorXd* values : {&state.v, &state.a, &state.a_mean, &state.acceleration}) {
      if (values->size() > 0) values->segment<3>(3 * node).setZero();
    }
  }
  if (remembers()) {
    state.past.setZero(8, 3 * static_cast<Eigen::Index>(model_.free.size()));
    state.past_next = 0;
    remember(state.v, state);
  }
  if (!model_.integrator->keeps_history()) return {};
  state.relative_velocity.resize(0);  // it may be another holder's
  Eigen::VectorXd a = state.acceleration;
  const Eigen::VectorXd kept = a;
  for (int node : model_.free) a.segment<3>(3 * node).setZero();
  for (const LoosePorts::Port& port : loose_.ports()) {
    for (int node : port.average.nodes()) a.segment<3>(3 * node) = kept.segment<3>(3 * node);
  }
  Eigen::VectorXd react;
  const SolveReport report = accelerate(state, a, react);
  for (int node : model_.free) {
    state.a.segment<3>(3 * node) = a.segment<3>(3 * node);
    state.acceleration.segment<3>(3 * node) = a.segment<3>(3 * node);
  }
  return report;
}

/// A step that ends at t = 0.
SolveReport TransientStep::settle(const MotionSet& motions, State& state,
                                  WrenchSet& wrenches) const {
  const SimTime h = model_.params.micro_step;
  State before = state;
  before.time = -h;
  before.generation = 1;  // any but 0: nothing is kept yet
  before.v.setZero();
  if (remembers()) before.past.setZero(8, 3 * static_cast<Eigen::Index>(model_.free.size()));
  before.support = Eigen::VectorXd::Zero(state.x.size());
  before.port_wrenches.resize(motions.size());
  Linearisation kept;
  Result result = advance(before, motions, motions, h, kept);
  if (result.report.outcome == Outcome::Failed) return result.report;
  result.state.book = {};
  state.x = result.state.x;
  for (int node : model_.free) state.v.segment<3>(3 * node).setZero();
  result.state.v = std::move(state.v);
  state = std::move(result.state);
  wrenches = std::move(result.wrenches);
  return result.report;
}

}  // namespace tandem::fem
