#include "fem_process/transient/step_tangent.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "fem_process/matrix/node_vectors.h"
#include "fem_process/transient/condensed_step.h"

/// The balance of forces along a direction; its kinematics are in step_tangent_motion.cpp.
namespace tandem::fem {

Eigen::VectorXd StepTangent::damped_change(const Direction& direction) const {
  return direction.dv + direction.d_shift - direction.d_reference;
}

/// Of the velocities in W that mass damping brakes.
Eigen::VectorXd StepTangent::drag_change(const Direction& direction) const {
  Eigen::VectorXd dragged = direction.dv;
  if (direction.d_drag.size() == 0) return dragged;
  const Eigen::VectorXd& d_drag = direction.d_drag;
  for (int node : model_.free) dragged.segment<3>(3 * node) += d_drag.segment<3>(3 * node);
  if (model_.integrator->keeps_history()) return dragged;
  for (int node : model_.prescribed) dragged.segment<3>(3 * node) += d_drag.segment<3>(3 * node);
  return dragged;
}

/// Of the damping forces; empty: undamped.
Eigen::VectorXd StepTangent::damping_change(const Step& step, const Direction& direction) const {
  if (direction.d_reference.size() == 0) return {};
  const Damping& damping = model_.params.damping;
  const Linearisation& last = step.last();
  Eigen::VectorXd change =
      damping.alpha_per_s * multiply_scalar(model_.pattern(), model_.mass, drag_change(direction));
  if (damping.beta_s == 0.0) return change;
  change += multiply(model_.pattern(), last.stiffness(), damping.beta_s * damped_change(direction));
  const bool iterated = last.kind == Linearisation::Kind::Iterated;
  if (!iterated && !direction.started()) return change;
  // K(x̃) turns with x̃, which an iteration takes to the step's end.
  Eigen::VectorXd dx = iterated ? direction.dd : Eigen::VectorXd::Zero(change.size());
  if (direction.started()) dx += direction.map.x_tilde;
  const Eigen::VectorXd at =
      iterated ? Eigen::VectorXd(last.map.x_tilde + step.result.d) : last.map.x_tilde;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(change.size());
  return change + step_.turning(last, at, damping.beta_s * step.result.damped, dx) -
         step_.turning(last, at, none, dx);
}

/// What the stiffness of the linearisation acts on.
Eigen::VectorXd StepTangent::strained(const Direction& direction) const {
  Eigen::VectorXd strained = direction.dd;
  if (direction.dd_first.size() > 0) strained -= direction.dd_first;
  const double beta_s = model_.params.damping.beta_s;
  if (beta_s > 0.0 && direction.d_reference.size() > 0) {
    strained += beta_s * damped_change(direction);
  }
  return strained;
}

/// Of x⁺, nodes with prescribed motion as the balance has them.
Eigen::VectorXd StepTangent::moved(const Direction& direction) const {
  Eigen::VectorXd dx = direction.dd;
  if (direction.started()) dx += direction.map.x_tilde;
  return dx;
}

/// residual() of many directions at all nodes, a column each; they meet the stiffness together.
Eigen::MatrixXd StepTangent::residuals(const Step& step,
                                       const std::vector<Eigen::Index>& moving) const {
  const auto count = static_cast<Eigen::Index>(moving.size());
  const auto direction_of = [&](Eigen::Index k) -> const Direction& {
    return directions_[static_cast<std::size_t>(moving[static_cast<std::size_t>(k)])];
  };
  Eigen::MatrixXd columns(step.begin.x.size(), count);
  if (count == 0) return columns;
  const Linearisation& kept = linearised(step, direction_of(0));
  const bool iterated = kept.kind == Linearisation::Kind::Iterated;
  for (Eigen::Index k = 0; k < count; ++k) {
    columns.col(k) = iterated ? moved(direction_of(k)) : strained(direction_of(k));
  }
  columns = iterated ? model_.formulation->derivatives(kept.map.x_tilde + step.result.d, columns)
                     : multiply_columns(model_.pattern(), kept.stiffness(), columns, *model_.team);
  for (Eigen::Index k = 0; k < count; ++k) {
    columns.col(k) = residual(step, direction_of(k), {}, columns.col(k));
  }
  return columns;
}

/// The linearisation in which the forces of the direction stand.
const Linearisation& StepTangent::linearised(const Step& step, const Direction& direction) const {
  const bool iterated = step.last().kind == Linearisation::Kind::Iterated;
  return direction.dd_first.size() > 0 || iterated ? step.last() : step.kept;
}

/// Derivative of M a + C w + T f_int − f_ext: of its linearisation at x̃ or, where the step is
/// iterated to equilibrium, of itself at x⁺. `elastic`: the part of the elastic forces, K times
/// strained() or f_int along moved(), where it is known.
Eigen::VectorXd StepTangent::residual(const Step& step, const Direction& direction,
                                      ProductPart part, Eigen::VectorXd elastic) const {
  const Damping& damping = model_.params.damping;
  const bool iterated = step.last().kind == Linearisation::Kind::Iterated;
  const Linearisation& kept = linearised(step, direction);
  const bool damped = direction.d_reference.size() > 0;
  const Eigen::VectorXd rate = damped ? damped_change(direction) : Eigen::VectorXd{};
  Eigen::VectorXd change;
  if (iterated) {
    const Eigen::VectorXd dx = moved(direction);
    const Eigen::VectorXd at = kept.map.x_tilde + step.result.d;
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(dx.size());
    change = elastic.size() > 0 ? std::move(elastic) : model_.formulation->derivative(at, none, dx);
    Eigen::VectorXd viscous = none;
    if (damping.beta_s > 0.0) {
      viscous = model_.formulation->derivative(at, damping.beta_s * step.result.damped, dx) -
                change + multiply(model_.pattern(), kept.K, damping.beta_s * rate, part);
    }
    carry_.take_mean(step.kept.carried, change);
    change += viscous;
  } else if (elastic.size() > 0) {
    change = std::move(elastic);
  } else {
    change = multiply(model_.pattern(), kept.stiffness(), strained(direction), part);
  }
  if (damping.alpha_per_s > 0.0) {
    change += damping.alpha_per_s *
              multiply_scalar(model_.pattern(), model_.mass, drag_change(direction), part);
  }
  if (direction.turning.size() > 0) change += direction.turning;
  change += multiply_scalar(model_.pattern(), model_.mass, direction.da, part);
  if (!loose_.empty()) loose_.add_forces(direction.d_phi, -1.0, change);
  return change;
}

/// What the arms of the torques add:  −Σ δ(p − about + R r) × g.
void StepTangent::add_arms(const Step& step, const Direction& direction,
                           WrenchSet& d_wrenches) const {
  for (std::size_t p = 0; p < arms_.size(); ++p) {
    const auto at = 3 * static_cast<Eigen::Index>(p);
    const Eigen::Vector3d turn = direction.d_arms_turn.segment<3>(at);
    const Eigen::Matrix3d R_WP = step.result.torques.pose[p].q_WP.toRotationMatrix();
    for (std::size_t k = 0; k < arms_[p].size(); ++k) {
      const Eigen::Vector3d arm =
          direction.d_origin.segment<3>(at) + turn.cross(R_WP * arms_[p][k]);
      d_wrenches[p].t_P_W -= arm.cross(step.result.react.segment<3>(3 * model_.ports[p].nodes[k]));
    }
  }
}

/// Wrench derivatives of one direction, and the state's after the step where either needs it.
void StepTangent::answer(const Step& step, Eigen::Index column, const AngularBalance* angular,
                         Direction& direction) {
  WrenchSet d_wrenches(arms_.size());
  Eigen::VectorXd d_react = Eigen::VectorXd::Zero(step.begin.x.size());
  if (direction.moves) {
    const ProductPart part{.rows = &model_.prescribed};
    d_react = residual(step, direction, part);
    for (int node : model_.free) d_react.segment<3>(3 * node).setZero();
    d_wrenches = port_wrenches(model_, arms_, step.result.torques, d_react);
    if (step.loose != nullptr) {
      const Eigen::VectorXd dx = moved(direction);
      add_wrench_derivative(loose_, step.result.torques.about, step.result.q,
                            step.result.state.attached, direction.d_about,
                            arms_change(step, direction, dx), direction.d_phi, d_wrenches);
      loose_.add_forces(direction.d_phi, 1.0, d_react);
    }
  }
  add_arms(step, direction, d_wrenches);
  if (angular != nullptr || micro_steps_ > 1) {
    State after = concluded(step, direction);
    if (angular != nullptr) {
      angular->add_change({.x_end = after.x,
                           .v_end = after.v,
                           .react = d_react,
                           .damping = damping_change(step, direction),
                           .x_begin = direction.begin.x,
                           .v_begin = direction.begin.v,
                           .x_middle = direction.map.x_tilde},
                          d_wrenches);
    }
    direction.begin = std::move(after);
    direction.port_begin = direction.port_end;
  }
  jacobian_.col(column) = stack(d_wrenches);
}

/// Corrects dv of the moving directions to the derivative of the balance of forces. Once with the
/// step's own matrix; where the step is iterated, that matrix leaves out what K does, and the
/// correction is repeated until nothing is left, as the iteration of the step itself.
SolveReport StepTangent::solve(const Step& step, const std::vector<Eigen::Index>& moving) {
  const SolverParams& params = model_.params.solver;
  const Linearisation& kept =
      step.last().kind == Linearisation::Kind::Iterated ? step.last() : step.kept;
  const double limit =
      params.kind == SolverKind::Pcg ? std::max(1e-10, 2.0 * params.tolerance) : 1e-10;
  const bool iterated = step.last().kind == Linearisation::Kind::Iterated;
  const int most = iterated ? 100 : 1;
  const auto count = static_cast<Eigen::Index>(moving.size());
  Eigen::MatrixXd delta(3 * static_cast<Eigen::Index>(model_.free.size()), count);
  Eigen::VectorXd norms(count);
  SolveReport total;
  for (int round = 0; round < most; ++round) {
    bool done = round > 0;
    const Eigen::MatrixXd left = -residuals(step, moving);
    for (Eigen::Index k = 0; k < count; ++k) {
      delta.col(k) = gather(left.col(k), model_.free);
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
      take(step, delta.col(k), direction);
      if (step.loose == nullptr) continue;
      Eigen::VectorXd pulled = Eigen::VectorXd::Zero(direction.dv.size());
      loose_.add_forces(direction.d_phi, 1.0, pulled);
      norms(k) = std::max(norms(k), pulled.norm());
    }
  }
  if (iterated) {
    total.outcome = std::max(total.outcome, Outcome::NotConverged);
    total.message = "the interface Jacobian has not converged in " + std::to_string(most) +
                    " solves. Choose fem.formulation corotational_consistent, or shorten "
                    "fem.micro_step_s.";
  }
  return total;
}

/// Corrects the velocities of the free nodes, and what follows from them.
void StepTangent::take(const Step& step, const Eigen::VectorXd& column,
                       Direction& direction) const {
  scatter_add(column, model_.free, direction.dv);
  scatter_add(Eigen::VectorXd(step.kept.map.c_x * column), model_.free, direction.dd);
  scatter_add(Eigen::VectorXd(step.kept.map.c_a * column), model_.free, direction.da);
  if (step.loose != nullptr) attach(step, direction);
}

/// Through the correction of the step's first solution: S δ = −r(x_1) with the first matrix, so
/// that
///   S dδ = −dr(x_1) − dS δ.
SolveReport StepTangent::correct_once(const Step& step, const std::vector<Eigen::Index>& moving) {
  const Linearisation& first = step.kept;
  const Linearisation& again = step.last();
  const TransientStep::Result& result = step.result;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(step.begin.x.size());
  const auto count = static_cast<Eigen::Index>(moving.size());
  Eigen::MatrixXd delta(3 * static_cast<Eigen::Index>(model_.free.size()), count);
  // K(x̃) acts on what the correction moves and on all that is damped: in the residual at x_1 and in
  // S δ together as much as in the reaction afterwards.
  Eigen::VectorXd y = result.d;
  if (result.damped.size() > 0) y += model_.params.damping.beta_s * result.damped;
  const auto direction_of = [&](Eigen::Index k) -> Direction& {
    return directions_[static_cast<std::size_t>(moving[static_cast<std::size_t>(k)])];
  };
  Eigen::MatrixXd dx(step.begin.x.size(), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    Direction& direction = direction_of(k);
    direction.dd_first = direction.dd;
    dx.col(k) = moved(direction);
  }
  const Eigen::MatrixXd of_force = model_.formulation->derivatives(again.map.x_tilde, dx);
  for (Eigen::Index k = 0; k < count; ++k) {
    Direction& direction = direction_of(k);
    direction.turning = of_force.col(k);
    if (direction.started()) {
      const Eigen::VectorXd& dx_tilde = direction.map.x_tilde;
      direction.turning += step_.turning(first, first.map.x_tilde, y, dx_tilde) -
                           step_.turning(first, first.map.x_tilde, none, dx_tilde);
    }
  }
  const Eigen::MatrixXd left = -residuals(step, moving);
  for (Eigen::Index k = 0; k < count; ++k) delta.col(k) = gather(left.col(k), model_.free);
  const Eigen::VectorXd norms = delta.colwise().norm();
  const SolveReport report = first.solver->solve(delta, norms);
  if (report.outcome == Outcome::Failed) return report;
  for (Eigen::Index k = 0; k < count; ++k) {
    take(step, delta.col(k),
         directions_[static_cast<std::size_t>(moving[static_cast<std::size_t>(k)])]);
  }
  return report;
}

/// Adds what the ports' forces do to the derivatives so far.
void StepTangent::attach(const Step& step, Direction& direction) const {
  const Linearisation& kept =
      step.last().kind == Linearisation::Kind::Iterated ? step.last() : step.kept;
  const Eigen::VectorXd dx = moved(direction);
  const Eigen::VectorXd correction =
      step.loose->correction(dx, direction.dv, direction.d_phi, direction.d_seen);
  const Eigen::VectorXd column = kept.port_columns * correction;
  direction.d_phi += correction;
  scatter_add(column, model_.free, direction.dv);
  scatter_add(Eigen::VectorXd(kept.map.c_x * column), model_.free, direction.dd);
  scatter_add(Eigen::VectorXd(kept.map.c_a * column), model_.free, direction.da);
}

SolveReport StepTangent::advance(const State& begin, const Motions& end, const MotionSet& about,
                                 const TransientStep::Result& result, const Linearisation& kept) {
  Step step{begin, end, about, result, kept, nullptr};
  const Linearisation& last = kept.last();
  if (loose_.empty() && micro_steps_ == 1 && condenses(model_, last)) {
    const AngularBalance angular(model_, carry_, balanced(begin, kept, result));
    return condense(model_, arms_, end.value, {result.torques, angular}, kept, jacobian_);
  }
  const Eigen::Index columns = 12 * static_cast<Eigen::Index>(arms_.size());
  directions_.resize(static_cast<std::size_t>(columns));
  jacobian_.setZero(columns / 2, columns);
  const bool corrected = last.kind == Linearisation::Kind::Corrected;
  std::optional<LooseTangent> first;
  std::optional<LooseTangent> solution;
  if (!loose_.empty()) {
    LooseTangent::Solution at{.end = result.seen,
                              .x = last.map.x_tilde + result.d,
                              .v = result.y,
                              .phi = result.state.attached,
                              .Y = last.port_response,
                              .c_x = last.map.c_x};
    solution.emplace(loose_, at);
    step.loose = &*solution;
    if (corrected) {
      at.x = last.map.x_tilde;
      at.v = result.first_y;
      at.phi = result.first_attached;
      step.loose = &first.emplace(loose_, at);
    }
  }
  std::vector<Eigen::Index> moving;
  for (Eigen::Index c = 0; c < columns; ++c) {
    Direction& direction = directions_[static_cast<std::size_t>(c)];
    prescribe(step, c, direction);
    if (direction.moves) moving.push_back(c);
  }
  SolveReport report;
  if (!moving.empty()) report = solve(step, moving);
  if (solution) step.loose = &*solution;
  if (report.outcome != Outcome::Failed && !moving.empty() && corrected) {
    const SolveReport second = correct_once(step, moving);
    report.iterations += second.iterations;
    if (second.outcome > report.outcome) {
      report.outcome = second.outcome;
      report.message = second.message;
    }
  }
  if (report.outcome == Outcome::Failed) return report;
  std::optional<AngularBalance> angular;
  if (step_.balances_angular()) angular.emplace(model_, carry_, balanced(begin, kept, result));
  for (Eigen::Index c = 0; c < columns; ++c) {
    answer(step, c, angular ? &*angular : nullptr, directions_[static_cast<std::size_t>(c)]);
  }
  return report;
}

}  // namespace tandem::fem
