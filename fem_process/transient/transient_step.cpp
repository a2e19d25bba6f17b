#include "fem_process/transient/transient_step.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "fem_process/body/round_off.h"
#include "fem_process/elements/make_formulation.h"
#include "fem_process/matrix/node_vectors.h"
#include "fem_process/matrix/velocity_projection.h"
#include "fem_process/solvers/rest_factor.h"
#include "fem_process/solvers/rest_multigrid.h"
#include "fem_process/transient/angular_balance.h"
#include "fem_process/transient/step_energy.h"
#include "fem_process/transient/step_matrix.h"
#include "protocol/contract/cost.h"

namespace tandem::fem {
namespace {

/// Free nodes up to which a factor at rest is preferred to multigrid: above, its set-up takes
/// seconds and its memory grows faster than the mesh (docs/fem_speed.md).
constexpr int kMostFactorised = 10000;

PortArms arms_of_rigid_ports(const Model& model, PortArms arms) {
  for (std::size_t p = 0; p < arms.size(); ++p) {
    if (model.ports[p].attachment.loose()) arms[p].clear();
  }
  return arms;
}

}  // namespace

TransientStep::TransientStep(const Model& model, PortArms arms)
    : model_(model),
      arms_(arms_of_rigid_ports(model, arms)),
      loose_(model, arms),
      carry_(make_carry(model, loose_)),
      node_rotations_(model.mesh, model.pattern(), model.free),
      rest_(factorize_at_rest()) {
  const FormulationKind kind = model.params.formulation;
  if (kind == FormulationKind::ConsistentCorotational || kind == FormulationKind::TotalLagrangian) {
    definite_ = make_formulation(FormulationKind::Corotational, model.mesh, model.materials);
  }
}

std::unique_ptr<const RestInverse> TransientStep::factorize_at_rest() const {
  const SolverParams& solver = model_.params.solver;
  if (solver.kind != SolverKind::Pcg || solver.preconditioner == PreconditionerKind::BlockJacobi) {
    return nullptr;
  }
  Eigen::VectorXd f_int;
  BlockValues K;
  BlockValues S;
  model_.formulation->evaluate(model_.reference(), f_int, K);
  // The map's coefficients depend on the step's length alone.
  const StepMap map = model_.integrator->map(State{}, to_seconds(model_.params.micro_step));
  step_matrix(map, K, S);
  const BlockPattern& pattern = model_.interior.pattern;
  if (solver.preconditioner == PreconditionerKind::WarpedRestMultigrid ||
      (solver.preconditioner == PreconditionerKind::Automatic &&
       pattern.rows() > kMostFactorised)) {
    std::vector<Eigen::Vector3d> positions;
    for (int node : model_.free) positions.push_back(model_.mesh.X[static_cast<std::size_t>(node)]);
    return std::make_unique<const RestMultigrid>(pattern, S, positions);
  }
  return std::make_unique<const RestFactor>(pattern, S);
}

/// S_II = ∂(M a + r)/∂v of a step, with the stiffness K.
void TransientStep::step_matrix(const StepMap& map, const BlockValues& K, BlockValues& S) const {
  const Damping& damping = model_.params.damping;
  combine(model_.interior, map.c_a + damping.alpha_per_s, model_.mass, damping.beta_s + map.c_x, &K,
          S, *model_.team);
}

Eigen::VectorXd TransientStep::inertia(const Eigen::VectorXd& a, ProductPart part) const {
  if (model_.params.mass == MassKind::Consistent) {
    return multiply_scalar(model_.pattern(), model_.mass, a, part);
  }
  Eigen::VectorXd force(a.size());
  for (Eigen::Index i = 0; i < a.size(); i += 3) {
    force.segment<3>(i) = model_.nodal_mass[static_cast<std::size_t>(i) / 3] * a.segment<3>(i);
  }
  return force;
}

/// Whether the solver asks how large its right-hand sides are.
bool TransientStep::measures_residuals() const {
  return model_.params.solver.kind == SolverKind::Pcg;
}

bool TransientStep::remembers() const {
  const SolverParams& solver = model_.params.solver;
  return solver.kind == SolverKind::Pcg && solver.initial_guess == InitialGuess::Projection;
}

void TransientStep::remember(const Eigen::VectorXd& v, State& state) const {
  state.past.row(state.past_next) = gather(v, model_.free).transpose();
  state.past_next = (state.past_next + 1) % 8;
}

Eigen::VectorXd TransientStep::damping_force(const BlockValues& K, const Eigen::VectorXd& v,
                                             const Eigen::VectorXd& beyond) const {
  const Damping& damping = model_.params.damping;
  return damping.alpha_per_s * multiply_scalar(model_.pattern(), model_.mass, v) +
         multiply(model_.pattern(), K, damping.beta_s * beyond);
}

void TransientStep::prescribe(const MotionSet& motions, Eigen::VectorXd& x,
                              Eigen::VectorXd& v) const {
  for (std::size_t p = 0; p < arms_.size(); ++p) {
    const Eigen::Matrix3d R_WP = motions[p].q_WP.toRotationMatrix();
    for (std::size_t k = 0; k < arms_[p].size(); ++k) {
      const Eigen::Vector3d r_W = R_WP * arms_[p][k];
      const int node = model_.ports[p].nodes[k];
      x.segment<3>(3 * node) = motions[p].p_WP + r_W;
      v.segment<3>(3 * node) = motions[p].v_WP + motions[p].w_WP.cross(r_W);
    }
  }
  for (int node : model_.fixed) v.segment<3>(3 * node).setZero();
}

TorqueArms arms_at(const MotionSet& motions) {
  TorqueArms arms{.pose = motions, .about = {}};
  for (const Motion& motion : motions) arms.about.push_back(motion.p_WP);
  return arms;
}

WrenchSet port_wrenches(const Model& model, const PortArms& arms, const TorqueArms& at,
                        const Eigen::VectorXd& react) {
  WrenchSet wrenches(arms.size());
  for (std::size_t p = 0; p < arms.size(); ++p) {
    const Eigen::Matrix3d R_WP = at.pose[p].q_WP.toRotationMatrix();
    const Eigen::Vector3d origin = at.pose[p].p_WP - at.about[p];
    for (std::size_t k = 0; k < arms[p].size(); ++k) {
      const Eigen::Vector3d g = react.segment<3>(3 * model.ports[p].nodes[k]);
      wrenches[p].f_P_W -= g;
      wrenches[p].t_P_W -= (origin + R_WP * arms[p][k]).cross(g);
    }
  }
  return wrenches;
}

void TransientStep::prepare(const State& state, Linearisation& kept) const {
  static_cast<void>(linearise(state, to_seconds(model_.params.micro_step), kept));
}

Eigen::VectorXd TransientStep::commanded_forces(const State& state) const {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(state.x.size());
  add_forces(state.boundary, model_.mesh, f);
  return f;
}

/// Whether the step's first solution is corrected: where K is not the derivative of f_int and the
/// method damps little.
bool TransientStep::corrects(const Linearisation& kept) const {
  return model_.integrator->keeps_history() &&
         (kept.stands_in || model_.params.formulation == FormulationKind::Corotational);
}

bool TransientStep::is_damped() const {
  const Damping& damping = model_.params.damping;
  return damping.alpha_per_s > 0.0 || damping.beta_s > 0.0;
}

/// Velocities beyond the rigid motion with what holds the body; empty without damping.
Eigen::VectorXd TransientStep::damped(const Input& input, const Eigen::VectorXd& v) const {
  if (input.reference.size() == 0) return {};
  return v + input.shift - input.reference;
}

/// Velocities in W. Prescribed nodes have them already where the balance is that of the end.
Eigen::VectorXd TransientStep::dragged(const Input& input, const Eigen::VectorXd& v) const {
  Eigen::VectorXd rate = v + input.carried.drag;
  if (model_.integrator->keeps_history()) {
    for (int node : model_.prescribed) rate.segment<3>(3 * node) = v.segment<3>(3 * node);
  }
  return rate;
}

Eigen::VectorXd TransientStep::balance(const Linearisation& kept, const Input& input,
                                       const Eigen::VectorXd& attached, const Eigen::VectorXd& v,
                                       const Eigen::VectorXd& d, const Eigen::VectorXd& a,
                                       ProductPart part) const {
  const Damping& damping = model_.params.damping;
  const Eigen::VectorXd rate = damped(input, v);
  Eigen::VectorXd strained = d;
  if (damping.beta_s > 0.0) strained += damping.beta_s * rate;
  Eigen::VectorXd residual =
      kept.f_mean - input.f_ext + inertia(a, part) +
      multiply(model_.pattern(), kept.stiffness(), strained, part, model_.team.get());
  if (damping.alpha_per_s > 0.0) {
    residual += damping.alpha_per_s * inertia(dragged(input, v), part);
  }
  if (!loose_.empty()) loose_.add_forces(attached, -1.0, residual);
  return residual;
}

/// Free nodes as if they came to rest: the right-hand side is what their balance then lacks.
void TransientStep::rest(const StepMap& map, Eigen::VectorXd& v, Eigen::VectorXd& d,
                         Eigen::VectorXd& a) const {
  for (int node : model_.free) {
    const Eigen::Index at = 3 * node;
    d.segment<3>(at) -= map.c_x * v.segment<3>(at);
    a.segment<3>(at) -= map.c_a * v.segment<3>(at);
    v.segment<3>(at).setZero();
  }
}

Eigen::VectorXd TransientStep::multiply_interior(const BlockValues& S,
                                                 const Eigen::VectorXd& v) const {
  return multiply(model_.interior.pattern, S, v, {}, model_.team.get());
}

void TransientStep::solve(const Input& input, const Linearisation& kept, Eigen::VectorXd& v,
                          Eigen::VectorXd& a, Result& result) const {
  const StepMap& map = kept.map;
  const State& begin = input.begin;
  const Eigen::VectorXd& attached = result.state.attached;
  Eigen::VectorXd& d = result.d;
  const bool projected = kept.S_past.size() > 0;
  if (projected) rest(kept.map, v, d, a);
  Eigen::MatrixXd delta = -gather(balance(kept, input, attached, v, d, a), model_.free);
  Eigen::VectorXd b = delta;
  if (!projected && measures_residuals()) b += multiply_interior(kept.S, gather(v, model_.free));
  const double start_s = now_s();
  if (projected) {
    const Eigen::VectorXd guess = project(begin.past, kept.S_past, b, *model_.team);
    scatter_add(guess, model_.free, v);
    scatter_add(Eigen::VectorXd(map.c_x * guess), model_.free, d);
    scatter_add(Eigen::VectorXd(map.c_a * guess), model_.free, a);
    delta = b - multiply_interior(kept.S, guess);
  }
  result.report = kept.solver->solve(delta, Eigen::VectorXd::Constant(1, b.norm()));
  result.times.solve_s = now_s() - start_s;
  if (result.report.outcome == Outcome::Failed) return;
  scatter_add(delta.col(0), model_.free, v);
  scatter_add(map.c_x * delta.col(0), model_.free, d);
  scatter_add(map.c_a * delta.col(0), model_.free, a);
  if (!loose_.empty()) {
    const SolveReport closed = attach(input, kept, v, a, result);
    if (closed.outcome != Outcome::Done) result.report = closed;
    if (closed.outcome == Outcome::Failed) return;
  }

  const ProductPart part{.rows = &model_.prescribed};
  result.react = balance(kept, input, attached, v, d, a, part);
  for (int node : model_.free) result.react.segment<3>(3 * node).setZero();
}

SolveReport TransientStep::attach(const Input& input, const Linearisation& kept, Eigen::VectorXd& v,
                                  Eigen::VectorXd& a, Result& result) const {
  const StepMap& map = kept.map;
  Eigen::VectorXd q = loose_.coordinates(map.x_tilde + result.d);
  Eigen::VectorXd q_rate = loose_.coordinates(v);
  Eigen::VectorXd attached = result.state.attached;
  const SolveReport report = loose_.close(input.seen, map.c_x, kept.port_response,
                                          loose_.coordinates(map.x_tilde), q, q_rate, attached);
  if (report.outcome == Outcome::Failed) return report;
  const Eigen::VectorXd delta = kept.port_columns * (attached - result.state.attached);
  scatter_add(delta, model_.free, v);
  scatter_add(Eigen::VectorXd(map.c_x * delta), model_.free, result.d);
  scatter_add(Eigen::VectorXd(map.c_a * delta), model_.free, a);
  result.state.attached = std::move(attached);
  return report;
}

/// Wrenches and energies of the ports at the end of the step, the nodes at `x_seen`.
void TransientStep::pull(const Carried& carried, const Eigen::VectorXd& x_seen,
                         Result& result) const {
  result.wrenches = port_wrenches(model_, arms_, result.torques, result.react);
  result.on_nodes = result.react;
  if (loose_.empty()) return;
  result.q = loose_.coordinates(x_seen);
  result.state.bushing_J = loose_.energy_J(result.seen.motions, result.q);
  if (balances_angular()) result.q = loose_.coordinates(carried.begin.x);
  const Eigen::VectorXd& attached = result.state.attached;
  loose_.add_wrenches(result.torques.about, result.q, attached, result.wrenches);
  loose_.add_forces(attached, 1.0, result.on_nodes);
}

TorqueArms TransientStep::torque_arms(const Carried& carried, const MotionSet& end,
                                      const MotionSet& about) const {
  TorqueArms arms = arms_at(end);
  if (!model_.integrator->constant_forces()) return arms;
  if (balances_angular()) arms.pose = carry_->turned_by_half(carried);
  for (std::size_t p = 0; p < end.size(); ++p) arms.about[p] = about[p].p_WP;
  return arms;
}

TransientStep::Result TransientStep::advance(const State& begin, const MotionSet& end,
                                             const MotionSet& about, SimTime h,
                                             Linearisation& kept) const {
  Result result = attempt(begin, end, about, h, kept);
  if (result.report.outcome != Outcome::Failed || !definite_ || kept.stands_in) return result;
  // Conjugate gradients find an indefinite matrix on their way.
  stand_in(kept);
  result = attempt(begin, end, about, h, kept);
  // Whether they do depends on the input: another one begins with the exact matrix again.
  kept.generation = 0;
  return result;
}

TransientStep::Result TransientStep::attempt(const State& begin, const MotionSet& end,
                                             const MotionSet& about, SimTime h,
                                             Linearisation& kept) const {
  Result result;
  result.times = linearise(begin, to_seconds(h), kept);
  result.report = kept.factorisation;
  if (kept.factorisation.outcome == Outcome::Failed) return result;
  const StepMap& map = kept.map;
  const SimTime time = begin.time + h;

  // Free nodes start from their last velocities; prescribed ones have their final motion.
  Eigen::VectorXd x = begin.x;
  Eigen::VectorXd v = kept.carried.begin.v;
  prescribe(end, x, v);
  carry_->see_prescribed(kept.carried, v);
  Eigen::VectorXd& d = result.d;
  Eigen::VectorXd d_hat = map.d_hat;
  const Eigen::VectorXd drift = carry_->drift(kept.carried, end);
  if (drift.size() > 0) d_hat += drift;
  d = d_hat + map.c_x * v;
  Eigen::VectorXd& a = result.a;
  a = map.a_hat + map.c_a * v;
  for (int node : model_.prescribed) {
    const Eigen::Index at = 3 * node;
    a.segment<3>(at) = map.a_hat_prescribed.segment<3>(at) + map.c_a_prescribed * v.segment<3>(at);
    if (map.prescribed_position) d.segment<3>(at) = x.segment<3>(at) - map.x_tilde.segment<3>(at);
  }
  if (const Eigen::VectorXd lacking = carry_->circling(kept.carried, end); lacking.size() > 0) {
    a += lacking;
  }
  result.seen = carry_->ports_seen(kept.carried, end);
  result.torques = torque_arms(kept.carried, end, about);
  if (model_.integrator->keeps_history()) {
    const LoosePorts::RigidStep rigid = carry_->rigid(kept.carried, end);
    result.rates = loose_.prescribe(map, rigid, d_hat, {end, result.seen}, d, a);
  }
  result.state.attached = begin.attached;
  const Eigen::VectorXd commanded = commanded_forces(begin);
  const Eigen::VectorXd f_ext = model_.external_forces(to_seconds(time)) + commanded;
  const Eigen::VectorXd reference =
      is_damped() ? carry_->reference(begin, kept.carried, end, f_ext) : Eigen::VectorXd{};
  const Eigen::VectorXd shift =
      is_damped() ? carry_->prescribed_shift(kept.carried, end, x, v) : Eigen::VectorXd{};
  const Input input{begin, end, result.seen, f_ext, reference, kept.carried, shift};
  kept.has_correction = false;
  solve(input, kept, v, a, result);
  if (result.report.outcome != Outcome::Failed && model_.params.integrator.newton_steps > 0) {
    correct(input, kept, v, a, result);
  } else if (result.report.outcome != Outcome::Failed && corrects(kept)) {
    correct_once(input, kept, v, a, result);
  }
  if (result.report.outcome == Outcome::Failed) return result;
  Eigen::VectorXd x_seen = kept.last().map.x_tilde + d;
  // Where the balance is that of the end, the forces have the arms of the end.
  if (model_.integrator->keeps_history()) loose_.follow(end, x_seen);
  for (int node : model_.free) x.segment<3>(3 * node) = x_seen.segment<3>(3 * node);
  pull(kept.carried, x_seen, result);
  result.damped = damped(input, v);
  if (is_damped()) result.dragged = dragged(input, v);
  if (remembers()) {
    result.state.past = begin.past;
    result.state.past_next = begin.past_next;
    remember(v, result.state);
  }
  result.state.boundary = begin.boundary;
  result.state.time = time;
  result.state.inverted_elements = kept.last().inverted_elements;
  result.y = std::move(v);
  carry_->conclude(begin, kept.carried,
                   {.x = std::move(x), .v = result.y, .a = a, .rates = result.rates, .end = end},
                   result.state);
  loose_.follow(end, result.state.x);
  if (balances_angular()) {
    result.external = f_ext;
    if (is_damped()) {
      result.external -= damping_force(kept.last().stiffness(), result.dragged, result.damped);
    }
    AngularBalance(model_, *carry_, balanced(begin, kept, result)).add(result.wrenches);
  }
  book_step(model_, begin,
            {.kept = kept.last(),
             .carried = kept.carried,
             .loose = loose_,
             .carry = *carry_,
             .f_begin = kept.f_int,
             .d = d,
             .react = result.on_nodes,
             .commanded = commanded,
             .damped = result.damped,
             .dragged = result.dragged,
             .motions = end,
             .wrenches = result.wrenches},
            result.state);
  return result;
}

}  // namespace tandem::fem
