#include "fem_process/transient/step_energy.h"

#include "fem_process/transient/interface_work.h"

namespace tandem::fem {
namespace {

/// α M v + β K w: mass damping of velocities in W, stiffness damping of those beyond a rigid
/// motion.
Eigen::VectorXd damping_force(const Model& model, const BlockValues& K, const Eigen::VectorXd& v,
                              const Eigen::VectorXd& w) {
  const Damping& damping = model.params.damping;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(v.size());
  if (damping.alpha_per_s > 0.0) {
    force += damping.alpha_per_s * multiply_scalar(model.pattern(), model.mass, v);
  }
  if (damping.beta_s > 0.0) {
    force += multiply(model.pattern(), K, damping.beta_s * w, {}, model.team.get());
  }
  return force;
}

bool is_damped(const Model& model) {
  const Damping& damping = model.params.damping;
  return damping.alpha_per_s > 0.0 || damping.beta_s > 0.0;
}

/// Q^−½ (x⁺ − c − Q (x − c)): how the nodes have moved but for the turn, in the balance's axes.
Eigen::VectorXd moved_beyond_turn(const StepForces& step, const State& begin, const State& after) {
  const Carried& carried = step.carried;
  Eigen::VectorXd moved(after.x.size());
  const std::vector<BodyPart>& parts = step.carry.parts();
  for (std::size_t s = 0; s < parts.size(); ++s) {
    const Carried::Turn& turn = carried.turns[s];
    const Eigen::Matrix3d back = turn.half.transpose();
    for (int node : parts[s].nodes) {
      const Eigen::Index row = 3 * node;
      const Eigen::Vector3d carried_x =
          turn.about + turn.Q * (begin.x.segment<3>(row) - turn.about);
      moved.segment<3>(row) = back * (after.x.segment<3>(row) - carried_x);
    }
  }
  return moved;
}

/// x with the rotations A of the parts' turns.
Eigen::VectorXd turned(const StepForces& step, const Eigen::VectorXd& x) {
  Eigen::VectorXd y(x.size());
  const std::vector<BodyPart>& parts = step.carry.parts();
  for (std::size_t s = 0; s < parts.size(); ++s) {
    const Eigen::Matrix3d& half = step.carried.turns[s].half;
    for (int node : parts[s].nodes) y.segment<3>(3 * node) = half * x.segment<3>(3 * node);
  }
  return y;
}

void book_end_forces(const Model& model, const State& begin, const StepForces& step, State& after) {
  const Linearisation& kept = step.kept;
  const double h_s = kept.h_s;
  const auto times_K = [&](const Eigen::VectorXd& x) {
    return multiply(model.pattern(), kept.stiffness(), x, {}, model.team.get());
  };
  const Eigen::VectorXd moved = after.x - begin.x;
  const Eigen::VectorXd mean = 0.5 * h_s * (begin.v + after.v);  // h v̄
  const Eigen::VectorXd delta = moved_beyond_turn(step, begin, after);
  const Eigen::VectorXd Kd = times_K(step.d);
  const Eigen::VectorXd Ke = times_K(delta - (kept.map.x_tilde + step.d - step.carried.begin.x));
  const double interface_J = -h_s * interface_power_W(step.wrenches, step.motions);
  const Eigen::VectorXd load = model.loads(to_seconds(after.time)) + step.commanded;
  Eigen::VectorXd f_ext = load;
  for (int i = 0; i < model.mesh.nodes(); ++i) {
    f_ext.segment<3>(3 * i) +=
        model.nodal_mass[static_cast<std::size_t>(i)] * model.params.gravity_m_per_s2;
  }
  const double elastic_J = 0.5 * delta.dot(step.f_begin + kept.f_int + Kd + Ke);
  double numerical_J = f_ext.dot(moved - mean) + interface_J - mean.dot(step.react) +
                       mean.dot(kept.f_mean + Kd) - elastic_J;
  if (is_damped(model)) {
    const Eigen::VectorXd drag = model.params.damping.alpha_per_s *
                                 multiply_scalar(model.pattern(), model.mass, step.dragged);
    const Eigen::VectorXd viscous =
        damping_force(model, kept.stiffness(), step.dragged, step.damped);
    const double damping_J = h_s * (step.dragged.dot(drag) + step.damped.dot(viscous - drag));
    numerical_J += mean.dot(viscous) - damping_J;
    after.book.damping_loss_J += damping_J;
  }
  after.book.interface_work_J += interface_J;
  after.book.external_work_J += load.dot(moved);
  after.book.numerical_loss_J += numerical_J;
  if (begin.moved.size() > 0) {
    after.book.numerical_loss_J +=
        begin.elastic_guess_J - 0.5 * turned(step, begin.moved).dot(step.f_begin);
  }
  after.elastic_guess_J = elastic_J - 0.5 * delta.dot(step.f_begin);
  after.moved = turned(step, delta);
}

void book_trapezoids(const Model& model, const State& begin, const StepForces& step, State& after) {
  const Eigen::VectorXd moved = after.x - begin.x;
  const double interface_J =
      -interface_trapezoid_J(begin.port_motions, step.motions, begin.port_wrenches, step.wrenches);
  const Eigen::VectorXd loads = model.loads(to_seconds(begin.time)) +
                                model.loads(to_seconds(after.time)) + 2.0 * step.commanded;
  double numerical_J = interface_J;
  numerical_J -= 0.5 * (moved.dot(begin.support) + moved.dot(step.react));
  after.support = step.react;
  if (model.integrator->inertia()) {
    const Eigen::VectorXd impulse = multiply_scalar(model.pattern(), model.mass, after.v - begin.v);
    numerical_J -= 0.5 * (begin.v + after.v).dot(impulse);
    numerical_J += 0.5 * moved.dot(multiply_scalar(model.pattern(), model.mass,
                                                   begin.acceleration + after.acceleration));
  }
  if (!step.loose.empty()) {
    // The forces of the balance, of which all works so far are, belong to the positions x̃ + d:
    // LoosePorts::follow() has moved nodes on to the pose of their port.
    const Eigen::VectorXd e = after.x - (step.kept.map.x_tilde + step.d);
    after.beyond = multiply(model.pattern(), step.kept.stiffness(), e, {}, model.team.get());
    numerical_J -= 0.5 * moved.dot(after.beyond);
    if (begin.beyond.size() > 0) numerical_J -= 0.5 * moved.dot(begin.beyond);
  }
  if (is_damped(model)) {
    after.damping_force = damping_force(model, step.kept.stiffness(), step.dragged, step.damped);
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
  // Of the set as it stands, carried along by the port: then a bushing damps nothing.
  Eigen::VectorXd with_port = q_rate;
  for (std::size_t k = 0; k < loose.ports().size(); ++k) {
    const Motion& motion = motions[loose.ports()[k].index];
    const Eigen::Index row = 12 * static_cast<Eigen::Index>(k);
    const Eigen::Vector3d arm = q.segment<3>(row) - motion.p_WP;
    with_port.segment<3>(row) = motion.v_WP + motion.w_WP.cross(arm);
    for (Eigen::Index j = row + 3; j < row + 12; j += 3) {
      with_port.segment<3>(j) = motion.w_WP.cross(Eigen::Vector3d(q.segment<3>(j)));
    }
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
                const Eigen::VectorXd& damped, State& state) {
  if (model.integrator->constant_forces()) return;
  state.beyond.resize(0);
  state.support = react;
  if (is_damped(model)) state.damping_force = damping_force(model, K, state.v, damped);
}

}  // namespace tandem::fem
