#include "fem_process/step_energy.h"

#include "fem_process/interface_work.h"

namespace tandem::fem {
namespace {

/// C v = α M v + β K v.
Eigen::VectorXd damping_force(const Model& model, const BlockValues& K, const Eigen::VectorXd& v) {
  const Damping& damping = model.params.damping;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(v.size());
  if (damping.alpha_per_s > 0.0) {
    force += damping.alpha_per_s * multiply_scalar(model.pattern(), model.mass, v);
  }
  if (damping.beta_s > 0.0) {
    force += multiply(model.pattern(), K, damping.beta_s * v, {}, model.team.get());
  }
  return force;
}

bool is_damped(const Model& model) {
  const Damping& damping = model.params.damping;
  return damping.alpha_per_s > 0.0 || damping.beta_s > 0.0;
}

void book_end_forces(const Model& model, const State& begin, const StepForces& step, State& after) {
  const Damping& damping = model.params.damping;
  const Linearisation& kept = step.kept;
  const double h_s = kept.h_s;
  const Eigen::VectorXd moved = after.x - begin.x;
  const Eigen::VectorXd D = kept.map.x_tilde + step.d - begin.x;
  const Eigen::VectorXd change = after.v - begin.v;
  const Eigen::VectorXd impulse = multiply_scalar(model.pattern(), model.mass, change);
  const Eigen::VectorXd KD = multiply(model.pattern(), kept.K, D, {}, model.team.get());

  // C v⁺ with v⁺ = D/h
  Eigen::VectorXd viscous = (damping.beta_s / h_s) * KD;
  if (damping.alpha_per_s > 0.0) {
    viscous += damping.alpha_per_s * multiply_scalar(model.pattern(), model.mass, after.v);
  }
  // Nodes of averaging ports go to their port's pose, too.
  const std::vector<int>& held = model.prescribed;
  const Eigen::VectorXd e = moved - D;
  const ProductPart part =
      step.loose.empty() ? ProductPart{.columns = &held, .rows = &held} : ProductPart{};
  const Eigen::VectorXd Ke = multiply(model.pattern(), kept.K, e, part, model.team.get());
  const Eigen::VectorXd f_end =
      kept.f_int +
      (kept.iterated ? multiply(model.pattern(), kept.K, step.d, {}, model.team.get()) : KD);

  const double interface_J = -h_s * interface_power_W(step.wrenches, step.motions);
  const double kinematic_J =
      e.dot(impulse) / h_s + e.dot(viscous) - 0.5 * e.dot(Ke) - moved.dot(step.react) + interface_J;
  const Eigen::VectorXd load = model.loads(to_seconds(after.time)) + step.commanded;
  after.book.interface_work_J += interface_J;
  after.book.external_work_J += load.dot(moved);
  after.book.damping_loss_J += D.dot(viscous);
  after.book.numerical_loss_J += 0.5 * change.dot(impulse) + 0.5 * D.dot(KD) + kinematic_J;
  if (begin.moved.size() > 0) {
    after.book.numerical_loss_J += begin.elastic_guess_J - 0.5 * begin.moved.dot(step.f_begin);
  }
  after.elastic_guess_J =
      f_end.dot(moved) - 0.5 * D.dot(KD) + 0.5 * e.dot(Ke) - 0.5 * moved.dot(step.f_begin);
  after.moved = moved;
}

void book_trapezoids(const Model& model, const State& begin, const StepForces& step, State& after) {
  const Eigen::VectorXd moved = after.x - begin.x;
  const double interface_J =
      -interface_trapezoid_J(begin.port_motions, step.motions, begin.port_wrenches, step.wrenches);
  const Eigen::VectorXd loads = model.loads(to_seconds(begin.time)) +
                                model.loads(to_seconds(after.time)) + 2.0 * step.commanded;
  double numerical_J = interface_J;
  if (model.integrator->averages_forces()) {
    numerical_J -= 0.5 * (moved.dot(begin.force) + moved.dot(after.force));
  } else {
    numerical_J -= 0.5 * (moved.dot(begin.support) + moved.dot(step.react));
    after.support = step.react;
  }
  if (model.integrator->inertia()) {
    const Eigen::VectorXd impulse = multiply_scalar(model.pattern(), model.mass, after.v - begin.v);
    numerical_J -= 0.5 * (begin.v + after.v).dot(impulse);
    if (!model.integrator->averages_forces()) {
      numerical_J += 0.5 * moved.dot(multiply_scalar(model.pattern(), model.mass,
                                                     begin.acceleration + after.acceleration));
    }
  }
  if (!step.loose.empty()) {
    // The forces of the balance, of which all works so far are, belong to the positions x̃ + d:
    // LoosePorts::follow() has moved nodes on to the pose of their port.
    const Eigen::VectorXd e = after.x - (step.kept.map.x_tilde + step.d);
    after.beyond = multiply(model.pattern(), step.kept.K, e, {}, model.team.get());
    numerical_J -= 0.5 * moved.dot(after.beyond);
    if (begin.beyond.size() > 0) numerical_J -= 0.5 * moved.dot(begin.beyond);
  }
  if (is_damped(model)) {
    after.damping_force = damping_force(model, step.kept.K, after.v);
    after.book.damping_loss_J +=
        0.5 * (moved.dot(begin.damping_force) + moved.dot(after.damping_force));
  }
  after.book.interface_work_J += interface_J;
  after.book.external_work_J += 0.5 * loads.dot(moved);
  after.book.numerical_loss_J += numerical_J;
  after.port_motions = step.motions;
  after.port_wrenches = step.wrenches;
}

void book_bushings(const Model& model, const State& begin, const StepForces& step, State& after) {
  after.bushing_loss_W = bushing_loss_W(step.loose, step.motions, step.loose.coordinates(after.x),
                                        step.loose.coordinates(after.v));
  const double loss_W = model.integrator->constant_forces()
                            ? after.bushing_loss_W
                            : 0.5 * (begin.bushing_loss_W + after.bushing_loss_W);
  const double damping_J = step.kept.h_s * loss_W;
  after.book.damping_loss_J += damping_J;
  after.book.numerical_loss_J -= damping_J + (after.bushing_J - begin.bushing_J);
}

}  // namespace

double bushing_loss_W(const LoosePorts& loose, const MotionSet& motions, const Eigen::VectorXd& q,
                      const Eigen::VectorXd& q_rate) {
  Eigen::VectorXd with_port = q_rate;
  for (std::size_t k = 0; k < loose.ports().size(); ++k) {
    const LoosePorts::Port& port = loose.ports()[k];
    with_port.segment<12>(12 * static_cast<Eigen::Index>(k)) =
        rigid_rates(port.average, motions[port.index]);
  }
  const Eigen::VectorXd viscous =
      loose.bushing_forces(motions, q, q_rate) - loose.bushing_forces(motions, q, with_port);
  return viscous.dot(with_port - q_rate);
}

double kinetic_energy_J(const Model& model, const Eigen::VectorXd& v) {
  if (!model.integrator->inertia()) return 0.0;
  return 0.5 * v.dot(multiply_scalar(model.pattern(), model.mass, v));
}

void book_step(const Model& model, const State& begin, const StepForces& step, State& after) {
  after.book = begin.book;
  if (!step.loose.empty()) book_bushings(model, begin, step, after);
  if (model.integrator->constant_forces()) {
    book_end_forces(model, begin, step, after);
  } else {
    book_trapezoids(model, begin, step, after);
  }
}

void book_start(const Model& model, const BlockValues& K, const Eigen::VectorXd& react,
                State& state) {
  if (model.integrator->constant_forces()) return;
  state.beyond.resize(0);
  if (!model.integrator->averages_forces()) state.support = react;
  if (is_damped(model)) state.damping_force = damping_force(model, K, state.v);
}

}  // namespace tandem::fem
