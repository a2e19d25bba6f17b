#include "fem_process/step_tangent.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "fem_process/condensed_step.h"
#include "fem_process/node_vectors.h"

namespace tandem::fem {
namespace {

/// Motion with one of its 12 coordinates (see difference()) changed by
/// `amount`.
Motion nudged(Motion motion, Eigen::Index coordinate, double amount) {
  const Eigen::Vector3d axis = Eigen::Vector3d::Unit(coordinate % 3);
  switch (coordinate / 3) {
    case 0:
      motion.p_WP += amount * axis;
      break;
    case 1:
      motion.q_WP = Eigen::Quaterniond(Eigen::AngleAxisd(amount, axis)) * motion.q_WP;
      break;
    case 2:
      motion.v_WP += amount * axis;
      break;
    default:
      motion.w_WP += amount * axis;
  }
  return motion;
}

}  // namespace

/// The interpolation is linear in p, v, w of the end (central differences are
/// exact) and smooth in the angle, where 1e-4 rad leaves about 1e-9.
MotionDerivative interpolation_derivative(const Segment<MotionSet>& input, double s, SimTime H,
                                          VelocityRule rule) {
  MotionDerivative derivative(input.end.size(), Eigen::Matrix<double, 12, 12>::Identity());
  if (s >= 1.0) return derivative;
  if (s <= 0.0) {
    for (auto& block : derivative) block.setZero();
    return derivative;
  }
  const double amount = 1e-4;
  for (std::size_t p = 0; p < input.end.size(); ++p) {
    for (Eigen::Index c = 0; c < 12; ++c) {
      const Segment<MotionSet> below{{input.begin[p]}, {nudged(input.end[p], c, -amount)}};
      const Segment<MotionSet> above{{input.begin[p]}, {nudged(input.end[p], c, amount)}};
      derivative[p].col(c) =
          difference(interpolate(below, s, H, rule), interpolate(above, s, H, rule)) /
          (2.0 * amount);
    }
  }
  return derivative;
}

/// Derivatives before the solve: free nodes with dv = 0, prescribed nodes with
/// their final ones.
///   dx_i = δp + δθ × r,   dv_i = δv + δw × r + w × (δθ × r),   r = R_WP r_i
void StepTangent::prescribe(const Motions& end, const TransientStep::Result& result,
                            const Linearisation& kept, Eigen::Index column,
                            Direction& direction) const {
  const StepMap& map = kept.map;
  const Eigen::Index n = result.state.x.size();
  const bool started = direction.begin.x.size() > 0;
  if (started) {
    direction.map = model_.integrator->map(direction.begin, kept.h_s);
    if (!kept.iterated) {
      const Eigen::VectorXd y = model_.params.damping.beta_s * result.state.v + result.d;
      direction.turning = model_.formulation->derivative(map.x_tilde, y, direction.map.x_tilde);
    }
  }
  direction.dd = started ? direction.map.d_hat : Eigen::VectorXd::Zero(n);
  direction.da = started ? direction.map.a_hat : Eigen::VectorXd::Zero(n);
  direction.dv = Eigen::VectorXd::Zero(n);
  direction.dx = Eigen::VectorXd::Zero(n);
  const auto p = static_cast<std::size_t>(column / 12);
  const Eigen::Matrix<double, 12, 1> change = end.derivative[p].col(column % 12);
  const Eigen::Matrix3d R_WP = end.value[p].q_WP.toRotationMatrix();
  for (std::size_t k = 0; k < arms_[p].size(); ++k) {
    const Eigen::Vector3d r = R_WP * arms_[p][k];
    const Eigen::Vector3d turn = change.segment<3>(3).cross(r);
    const Eigen::Index at = 3 * model_.ports[p].nodes[k];
    direction.dx.segment<3>(at) = change.segment<3>(0) + turn;
    direction.dv.segment<3>(at) =
        change.segment<3>(6) + change.segment<3>(9).cross(r) + end.value[p].w_WP.cross(turn);
  }
  if (!model_.integrator->inertia()) direction.dv.setZero();
  for (int node : model_.prescribed) {
    const Eigen::Index at = 3 * node;
    Eigen::Vector3d da = map.c_a_prescribed * direction.dv.segment<3>(at);
    Eigen::Vector3d dd = map.prescribed_position ? Eigen::Vector3d(direction.dx.segment<3>(at))
                                                 : map.c_x * direction.dv.segment<3>(at);
    if (started) {
      da += direction.map.a_hat_prescribed.segment<3>(at);
      if (map.prescribed_position) {
        dd -= direction.map.x_tilde.segment<3>(at);
      } else {
        dd += direction.map.d_hat.segment<3>(at);
      }
    }
    direction.da.segment<3>(at) = da;
    direction.dd.segment<3>(at) = dd;
  }
  direction.moves = started || direction.dv.squaredNorm() + direction.dd.squaredNorm() > 0.0;
}

/// A column's change of its port's motion.
LooseTangent::Change StepTangent::change_of(const Motions& motions, Eigen::Index column) {
  const auto p = static_cast<std::size_t>(column / 12);
  return {p, motions.derivative[p].col(column % 12)};
}

void StepTangent::prescribe_loose(const Motions& end, const Linearisation& kept,
                                  const LooseTangent& loose, Eigen::Index column,
                                  Direction& direction) const {
  const bool started = direction.begin.x.size() > 0;
  const LooseTangent::Change change = change_of(end, column);
  direction.d_phi = Eigen::VectorXd::Zero(loose_.size());
  if (model_.integrator->keeps_history()) {
    LoosePorts::RigidStep d_rigid;
    if (started) d_rigid = loose_.rigid_step(*model_.integrator, direction.begin, kept.h_s);
    direction.d_rigid =
        loose.prescribe(kept.map, kept.rigid, started ? &direction.map : nullptr,
                        started ? &d_rigid : nullptr, change, direction.dd, direction.da);
  }
  const bool own = model_.ports[change.port].attachment.loose();
  direction.moves = direction.moves || (own && !change.motion.isZero(0.0));
}

/// Derivative of r = C v + f_int − f_ext: of its linearisation at x̃ or, where the step is iterated
/// to equilibrium, of r itself at x⁺.
Eigen::VectorXd StepTangent::force(const Direction& direction, const TransientStep::Result& result,
                                   const Linearisation& kept, ProductPart part) const {
  const Damping& damping = model_.params.damping;
  Eigen::VectorXd change;
  if (kept.iterated) {
    Eigen::VectorXd dx = direction.dd;
    if (direction.begin.x.size() > 0) dx += direction.map.x_tilde;
    change = model_.formulation->derivative(kept.map.x_tilde + result.d,
                                            damping.beta_s * result.state.v, dx);
    if (damping.beta_s > 0.0) {
      change += multiply(model_.pattern(), kept.K, damping.beta_s * direction.dv, part);
    }
  } else {
    change = multiply(model_.pattern(), kept.K, damping.beta_s * direction.dv + direction.dd, part);
  }
  if (damping.alpha_per_s > 0.0) {
    change +=
        damping.alpha_per_s * multiply_scalar(model_.pattern(), model_.mass, direction.dv, part);
  }
  if (direction.turning.size() > 0) change += direction.turning;
  return change;
}

/// Derivative of M a + θ r + (1 − θ) r_n.
Eigen::VectorXd StepTangent::residual(const Direction& direction, const Eigen::VectorXd& force,
                                      const Linearisation& kept, ProductPart part) const {
  const double theta = kept.map.theta;
  Eigen::VectorXd change =
      multiply_scalar(model_.pattern(), model_.mass, direction.da, part) + theta * force;
  if (direction.begin.force.size() > 0) change += (1.0 - theta) * direction.begin.force;
  if (loose_.empty()) return change;
  loose_.add_forces(direction.d_phi, -theta, change);
  if (direction.begin.attached.size() > 0) {
    loose_.add_forces(direction.begin.attached, theta - 1.0, change);
  }
  return change;
}

/// Wrench derivatives of one direction, and the derivative of the new state.
///   df = −Σ dg,   dt = −Σ r × dg − Σ (δθ × r) × g
void StepTangent::finish(const Motions& end, const Motions& torque_pose,
                         const TransientStep::Result& result, const Linearisation& kept,
                         const LooseTangent* loose, Eigen::Index column, Direction& direction) {
  // Where no later step needs the forces, the reactions alone are needed.
  ProductPart part;
  if (!model_.integrator->averages_forces()) part.rows = &model_.prescribed;
  Eigen::VectorXd d_force = force(direction, result, kept, part);
  Eigen::VectorXd d_react = residual(direction, d_force, kept, part);
  if (direction.begin.react.size() > 0) {
    d_react -= (1.0 - kept.map.theta) * direction.begin.react;
  }
  d_react /= kept.map.theta;
  for (int node : model_.free) d_react.segment<3>(3 * node).setZero();
  WrenchSet d_wrenches = port_wrenches(model_, arms_, torque_pose.value, d_react);
  const auto p = static_cast<std::size_t>(column / 12);
  const Eigen::Vector3d turn = torque_pose.derivative[p].block<3, 1>(3, column % 12);
  const Eigen::Matrix3d R_WP = torque_pose.value[p].q_WP.toRotationMatrix();
  for (std::size_t k = 0; k < arms_[p].size(); ++k) {
    const Eigen::Vector3d g = result.react.segment<3>(3 * model_.ports[p].nodes[k]);
    d_wrenches[p].t_P_W -= turn.cross(R_WP * arms_[p][k]).cross(g);
  }

  State after;
  after.x = direction.dx;
  for (int node : model_.free) {
    after.x.segment<3>(3 * node) = direction.dd.segment<3>(3 * node);
    if (direction.begin.x.size() > 0) {
      after.x.segment<3>(3 * node) += direction.map.x_tilde.segment<3>(3 * node);
    }
  }
  if (loose != nullptr) {
    loose->follow(change_of(end, column), after.x);
    Eigen::VectorXd dq = Eigen::VectorXd::Zero(loose_.size());
    if (!model_.integrator->torque_arms_at_begin()) {
      dq = loose_.coordinates(after.x);
    } else if (direction.begin.x.size() > 0) {
      dq = loose_.coordinates(direction.begin.x);
    }
    add_wrench_derivative(loose_, torque_pose.value, result.q, result.state.attached,
                          {p, torque_pose.derivative[p].col(column % 12)}, dq, direction.d_phi,
                          d_wrenches);
    after.attached = direction.d_phi;
  }
  jacobian_.col(column) = stack(d_wrenches);
  if (model_.integrator->keeps_history()) {
    if (direction.begin.x.size() == 0) {
      const Eigen::VectorXd zero = Eigen::VectorXd::Zero(after.x.size());
      direction.begin.v = direction.begin.a = zero;
      direction.begin.rigid.v = direction.begin.rigid.a = Eigen::VectorXd::Zero(loose_.size());
    }
    if (loose != nullptr) {
      after.rigid =
          kept_rates(*model_.integrator, direction.begin.rigid, direction.d_rigid, kept.h_s);
    }
    model_.integrator->keep(direction.begin, direction.dv, direction.da, kept.h_s, after);
  }
  if (model_.integrator->averages_forces()) {
    after.force = std::move(d_force);
    after.react = std::move(d_react);
  }
  after.v = direction.dv;
  direction.begin = std::move(after);
}

/// Corrects dv of the moving directions to the derivative of the balance of forces. Once with the
/// step's own matrix; where the step is iterated, that matrix leaves out what K does, and the
/// correction is repeated until nothing is left, as the iteration of the step itself.
SolveReport StepTangent::solve(const Motions& end, const std::vector<Eigen::Index>& moving,
                               const TransientStep::Result& result, const Linearisation& kept,
                               const LooseTangent* loose) {
  const SolverParams& params = model_.params.solver;
  const double limit =
      params.kind == SolverKind::Pcg ? std::max(1e-10, 2.0 * params.tolerance) : 1e-10;
  const int most = kept.iterated ? 100 : 1;
  const auto count = static_cast<Eigen::Index>(moving.size());
  Eigen::MatrixXd delta(3 * static_cast<Eigen::Index>(model_.free.size()), count);
  Eigen::VectorXd norms(count);
  SolveReport total;
  for (int round = 0; round < most; ++round) {
    bool done = round > 0;
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Index column = moving[static_cast<std::size_t>(k)];
      const Direction& direction = directions_[static_cast<std::size_t>(column)];
      // In the first micro step nothing but the port moves yet.
      ProductPart part;
      if (round == 0 && direction.begin.x.size() == 0) {
        part.columns = &model_.ports[static_cast<std::size_t>(column / 12)].nodes;
      }
      const Eigen::VectorXd change = force(direction, result, kept, part);
      delta.col(k) = -gather(residual(direction, change, kept, part), model_.free);
      if (round == 0) norms(k) = delta.col(k).norm();
      done = done && delta.col(k).norm() <= limit * norms(k);
    }
    if (done) return total;
    const SolveReport report = kept.solver->solve(delta, norms);
    total.iterations += report.iterations;
    total.outcome = std::max(total.outcome, report.outcome);
    if (total.message.empty()) total.message = report.message;
    if (report.outcome == Outcome::Failed) return total;
    for (Eigen::Index k = 0; k < count; ++k) {
      Direction& direction =
          directions_[static_cast<std::size_t>(moving[static_cast<std::size_t>(k)])];
      const Eigen::VectorXd column = delta.col(k);
      scatter_add(column, model_.free, direction.dv);
      scatter_add(Eigen::VectorXd(kept.map.c_x * column), model_.free, direction.dd);
      scatter_add(Eigen::VectorXd(kept.map.c_a * column), model_.free, direction.da);
      if (loose == nullptr) continue;
      attach(change_of(end, moving[static_cast<std::size_t>(k)]), kept, *loose, direction);
      Eigen::VectorXd pulled = Eigen::VectorXd::Zero(direction.dv.size());
      loose_.add_forces(direction.d_phi, kept.map.theta, pulled);
      norms(k) = std::max(norms(k), pulled.norm());
    }
  }
  if (kept.iterated) {
    total.outcome = std::max(total.outcome, Outcome::NotConverged);
    total.message = "the interface Jacobian has not converged in " + std::to_string(most) +
                    " solves. Choose fem.formulation corotational_consistent, or shorten "
                    "fem.micro_step_s.";
  }
  return total;
}

/// Adds what the ports' forces do to the derivatives so far.
void StepTangent::attach(const LooseTangent::Change& change, const Linearisation& kept,
                         const LooseTangent& loose, Direction& direction) const {
  Eigen::VectorXd dx = direction.dd;
  if (direction.begin.x.size() > 0) dx += direction.map.x_tilde;
  const Eigen::VectorXd correction = loose.correction(dx, direction.dv, direction.d_phi, change);
  const Eigen::VectorXd column = kept.port_columns * correction;
  direction.d_phi += correction;
  scatter_add(column, model_.free, direction.dv);
  scatter_add(Eigen::VectorXd(kept.map.c_x * column), model_.free, direction.dd);
  scatter_add(Eigen::VectorXd(kept.map.c_a * column), model_.free, direction.da);
}

SolveReport StepTangent::advance(const Motions& end, const Motions& torque_pose,
                                 const TransientStep::Result& result, const Linearisation& kept) {
  if (loose_.empty() && micro_steps_ == 1 && condenses(model_, kept)) {
    return condense(model_, arms_, end.value, torque_pose.value, kept, jacobian_);
  }
  const Eigen::Index columns = 12 * static_cast<Eigen::Index>(arms_.size());
  directions_.resize(static_cast<std::size_t>(columns));
  jacobian_.setZero(columns / 2, columns);
  std::optional<LooseTangent> solution;
  if (!loose_.empty()) {
    solution.emplace(loose_, LooseTangent::Solution{.end = end.value,
                                                    .x = kept.map.x_tilde + result.d,
                                                    .v = result.state.v,
                                                    .phi = result.state.attached,
                                                    .Y = kept.port_response,
                                                    .c_x = kept.map.c_x});
  }
  const LooseTangent* const loose = solution ? &*solution : nullptr;
  std::vector<Eigen::Index> moving;
  for (Eigen::Index c = 0; c < columns; ++c) {
    Direction& direction = directions_[static_cast<std::size_t>(c)];
    prescribe(end, result, kept, c, direction);
    if (loose != nullptr) prescribe_loose(end, kept, *loose, c, direction);
    if (direction.moves) {
      moving.push_back(c);
    } else if (direction.dx.squaredNorm() > 0.0) {
      // Backward Euler takes displacements from velocities: positions tell in
      // the next micro step.
      direction.begin.x = direction.dx;
      direction.begin.v = direction.dv;
    }
  }
  if (moving.empty()) return {};
  const SolveReport report = solve(end, moving, result, kept, loose);
  if (report.outcome == Outcome::Failed) return report;
  for (Eigen::Index column : moving) {
    finish(end, torque_pose, result, kept, loose, column,
           directions_[static_cast<std::size_t>(column)]);
  }
  return report;
}

}  // namespace tandem::fem
