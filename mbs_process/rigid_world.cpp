#include "mbs_process/rigid_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mbs_process/spring_stability.h"
#include "protocol/contract/error.h"

namespace tandem::mbs {
namespace {

Params checked(Params params) {
  check(params);
  for (BodyParams& body : params.bodies) body.q_WB.normalize();
  for (scenario::PortParams& port : params.ports) port.q_WP.normalize();
  return params;
}

bool all_finite(const BodyState& body) {
  return body.p_WB.allFinite() && body.q_WB.coeffs().allFinite() && body.v_WB.allFinite() &&
         body.w_WB.allFinite();
}

/// A number whose square comes near to overflowing, which ODE ends by an assertion.
constexpr double kMost = 1e100;

/// The torques of a macro step are about the ports' origins at its beginning: about where they are
/// now, they are others.
void take_about(const MotionSet& begin, const MotionSet& now, WrenchSet& wrenches) {
  for (std::size_t p = 0; p < wrenches.size(); ++p) {
    wrenches[p].t_P_W += (begin[p].p_WP - now[p].p_WP).cross(wrenches[p].f_P_W);
  }
}

bool bounded(const WrenchSet& wrenches) {
  return std::all_of(wrenches.begin(), wrenches.end(), [](const Wrench& wrench) {
    return wrench.f_P_W.norm() <= kMost && wrench.t_P_W.norm() <= kMost;  // false for NaN, too
  });
}

bool out_of_bounds(const BodyState& body) {
  return !all_finite(body) || body.v_WB.norm() > kMost || body.w_WB.norm() > kMost;
}

std::string at_time(SimTime t) { return fmt::format(" at t = {:.12g} s", to_seconds(t)); }

/// The body that moves fastest, or one that does not move by numbers.
std::size_t fastest(const std::vector<BodyState>& bodies) {
  const auto speed = [&](std::size_t i) { return bodies[i].v_WB.norm() + bodies[i].w_WB.norm(); };
  std::size_t found = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!all_finite(bodies[i])) return i;
    if (speed(i) > speed(found)) found = i;
  }
  return found;
}

}  // namespace

State initial_state(const Params& params) {
  State state;
  for (const BodyParams& body : params.bodies) {
    state.bodies.push_back({body.p_WB, body.q_WB, body.v_WB, body.w_WB});
  }
  state.joint_coordinates.assign(params.joints.size(), {0.0, 0.0});
  return state;
}

RigidWorld::RigidWorld(Params params)
    : params_(checked(std::move(params))),
      loads_(params_),
      rule_(wrench_rule(params_)),
      junction_rule_(junction_rule(params_)),
      world_(params_),
      gaps_(params_),
      state_(initial_state(params_)),
      saved_(state_) {
  info_.name = "mbs";
  info_.micro_step = params_.micro_step.value_or(params_.macro_step);
  info_.can_linearize = true;
  for (const JointParams& joint : params_.joints) joints_.emplace_back(params_, joint);
  for (const scenario::PortParams& port : params_.ports) {
    info_.ports.push_back({.name = port.name, .length_m = 0.0});
    const std::size_t index = body_index(params_, port.body).value();
    const BodyParams& body = params_.bodies[index];
    if (port.at_body_frame) {
      ports_.push_back({index, Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()});
    } else {
      const Eigen::Quaterniond q_BW = body.q_WB.conjugate();
      ports_.push_back({index, q_BW * (port.p_WP - body.p_WB), q_BW * port.q_WP});
    }
  }
  for (const BodyParams& body : params_.bodies) {
    if (!body.massless) continue;
    junctions_ = true;
    const bool euler = params_.integrator == IntegratorKind::Euler;
    info_.ports[port_at(params_, body).value()].stand_in = {
        .mass_kg = body.mass_kg,
        .inertia_kg_m2 = body.inertia_kg_m2[0],
        .gamma = euler ? 1.0 : junction_rule_.gamma,
        .alpha_m = junction_rule_.alpha_m,
        .alpha_f = junction_rule_.alpha_f};
  }
}

MotionSet RigidWorld::initialize(const WrenchSet& wrenches) {
  require(wrenches.size() == ports_.size(), "mbs: initialize was given " +
                                                std::to_string(wrenches.size()) + " wrenches for " +
                                                std::to_string(ports_.size()) + " ports.");
  state_ = initial_state(params_);
  saved_ = state_;
  return motions_of(state_);
}

StepResult<MotionSet> RigidWorld::advance(const StepRequest<WrenchSet>& request) {
  const double started_s = now_s();
  const std::size_t count = ports_.size();
  require(request.input.begin.size() == count && request.input.end.size() == count,
          "mbs: advance needs one wrench per port at both ends of the step: " +
              std::to_string(count) + ".");
  StepResult<MotionSet> result;
  const State begin = state_;
  State end = state_;
  kicks_.clear();
  // The response is that of one dWorldStep.
  recording_ = request.linearize && linearization_ == Linearization::Response &&
               params_.integrator == IntegratorKind::Euler &&
               micro_step_of(request.step) == request.step;
  std::optional<std::string> failure = integrate(end, request.step, request.input, Booking::On);
  recording_ = false;
  if (!failure && request.linearize) {
    std::string probe_failure;
    result.jacobian = linearised(begin, end, request, probe_failure);
    if (!result.jacobian) failure = probe_failure;
  }
  if (failure) {
    result.message = *failure;
    // Whatever ODE was in the middle of is thrown away; the state lives here.
    world_ = OdeWorld(params_);
  } else {
    state_ = std::move(end);
    result.outcome = Outcome::Done;
    result.message.clear();
    result.output = motions_of(state_);
  }
  result.cost.compute_s = now_s() - started_s;
  return result;
}

void RigidWorld::checkpoint() {
  saved_ = state_;
  if (sink_) sink_(saved_);
}

void RigidWorld::rollback() { state_ = saved_; }

Observation RigidWorld::observe() {
  Observation observation;
  observation.time = state_.time;
  observation.energy = state_.book;
  observation.energy.kinetic_J = kinetic_energy_J(state_);
  observation.energy.potential_J = loads_.spring_energy_J(state_);
  for (std::size_t i = 0; i < state_.bodies.size(); ++i) {
    if (params_.bodies[i].massless) continue;
    observation.energy.potential_J -=
        params_.bodies[i].mass_kg * params_.gravity_m_per_s2.dot(state_.bodies[i].p_WB);
  }
  observation.state_hash = hash_of(state_);
  observation.widest_joint = gaps_.widest(state_);
  return observation;
}

SimTime RigidWorld::micro_step_of(SimTime macro_step) const {
  require(macro_step.count() > 0, "mbs: a step must be longer than 0.");
  const SimTime h = params_.micro_step.value_or(macro_step);
  require(macro_step % h == SimTime{},
          "mbs: the macro step of " + std::to_string(macro_step.count()) +
              " ns is no whole multiple of mbs.micro_step_s = " + std::to_string(h.count()) +
              " ns. Change one of them.");
  return h;
}

MotionSet RigidWorld::motions_of(const State& state) const {
  MotionSet motions;
  motions.reserve(ports_.size());
  for (const Port& port : ports_) {
    const BodyState& body = state.bodies[port.body];
    const Eigen::Vector3d r = body.q_WB * port.p_BP;
    motions.push_back({.p_WP = body.p_WB + r,
                       .q_WP = (body.q_WB * port.q_BP).normalized(),
                       .v_WP = body.v_WB + body.w_WB.cross(r),
                       .w_WP = body.w_WB});
  }
  return motions;
}

std::optional<std::string> RigidWorld::integrate(State& state, SimTime macro_step,
                                                 const Segment<WrenchSet>& input, Booking booking) {
  const SimTime h = micro_step_of(macro_step);
  const std::int64_t n = macro_step / h;
  for (const WrenchSet* wrenches : {&input.begin, &input.end}) {
    if (bounded(*wrenches)) continue;
    return "mbs: a port wrench is not finite or beyond all bounds" + at_time(state.time) +
           ". The coupling has diverged: shorten the macro step.";
  }
  // Semi-implicit Euler takes the wrench as the mean over the macro step, which passes on the
  // impulse that the flexible side has booked; the Verlet step as linear between both ends.
  const bool constant = params_.integrator == IntegratorKind::Euler;
  const MotionSet about = constant && n > 1 ? motions_of(state) : MotionSet{};
  WrenchSet wrenches = input.begin;
  for (std::int64_t j = 1; j <= n; ++j) {
    const double s = static_cast<double>(j) / static_cast<double>(n);
    WrenchSet next = constant ? input.end : interpolate(input, s, macro_step);
    if (constant && j > 1) take_about(about, motions_of(state), next);
    if (auto failure = integrate_micro_step(state, h, {wrenches, next}, booking)) return failure;
    wrenches = std::move(next);
  }
  return std::nullopt;
}

std::optional<std::string> RigidWorld::integrate_micro_step(State& state, SimTime h,
                                                            const Segment<WrenchSet>& wrenches,
                                                            Booking booking) {
  const double h_s = to_seconds(h);
  StepWork work;
  StepWork* const booked = booking == Booking::On ? &work : nullptr;
  if (booked != nullptr) work.stored_change_J = -loads_.spring_energy_J(state);
  const std::vector<BodyState> begin = state.bodies;
  try {
    if (params_.integrator == IntegratorKind::Euler) {
      euler_step(state, h_s, wrenches.end, booked);
    } else {
      verlet_step(state, h_s, wrenches, booked);
    }
  } catch (const OdeFault& fault) {
    const std::size_t body = fastest(begin);
    if (out_of_bounds(begin[body])) return grown(body, state.time);
    return "mbs: " + std::string(fault.what()) + at_time(state.time) +
           ". Shorten the step, check masses and positions, or raise mbs.cfm where joints "
           "constrain the same motion twice.";
  }
  const std::size_t body = fastest(state.bodies);
  if (out_of_bounds(state.bodies[body])) return grown(body, state.time + h);
  if (booked != nullptr) {
    work.stored_change_J += loads_.spring_energy_J(state);
    work.book(state.book);
  }
  state.time += h;
  return std::nullopt;
}

std::string RigidWorld::grown(std::size_t body, SimTime t) const {
  const std::string what = "mbs: the motion of body '" + params_.bodies[body].name +
                           "' has grown beyond all bounds" + at_time(t) + ". ";
  const auto springs = spring_warning(params_);
  return what + springs.value_or("Shorten the step or check the loads on it.");
}

void RigidWorld::euler_step(State& state, double h_s, const WrenchSet& wrenches, StepWork* work) {
  std::vector<BodyWrench> applied(state.bodies.size());
  sorted_.reset(state.bodies.size());
  loads_.add_to(state, to_seconds(state.time) + h_s, applied, sorted_);
  add_port_wrenches(state, wrenches, applied);
  const std::vector<BodyState> before = state.bodies;
  world_.load(state.bodies, state.joint_coordinates);
  command_motors(state, h_s, MotorAim::Mean);
  world_.step(h_s, applied, whole_step(params_));
  world_.read(state.bodies);
  record(h_s, whole_step(params_), before, state.joint_coordinates, applied, state.bodies);
  track_coordinates(state, h_s);
  if (work == nullptr) return;
  for (std::size_t i = 0; i < before.size(); ++i) {
    sorted_.gyroscopic[i].t_B_W = implicit_gyroscopic_torque(params_.bodies[i], before[i], h_s);
  }
  world_.add_reactions(sorted_.motors, sorted_.joints);
  work->add(sorted_, state.bodies, h_s, 1.0);
  work->motors_J = work_J(sorted_.motors, state.bodies, h_s);
  work->kinetic_loss_J = velocity_change_J(params_, before, state.bodies);
  work->interface_J = h_s * interface_power_W(wrenches, motions_of(state));
  work->stand_in_J = stand_in_work_J(params_, before, state.bodies, state.bodies);
}

template <class Make>
WrenchSet RigidWorld::by_rule(const Make& make) const {
  WrenchSet wrenches = make(rule_);
  if (!junctions_) return wrenches;
  const WrenchSet of_junctions = make(junction_rule_);
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    if (params_.bodies[ports_[p].body].massless) wrenches[p] = of_junctions[p];
  }
  return wrenches;
}

void RigidWorld::verlet_step(State& state, double h_s, const Segment<WrenchSet>& wrenches,
                             StepWork* work) {
  const double t_s = to_seconds(state.time);
  const bool filters = params_.integrator == IntegratorKind::GeneralisedAlpha || junctions_;
  const WrenchSet before = filters && !state.filtered.empty() ? state.filtered : wrenches.begin;
  const WrenchSet after = by_rule(
      [&](const WrenchRule& rule) { return rule.filtered(before, wrenches.begin, wrenches.end); });
  if (filters) state.filtered = after;
  const std::vector<BodyState> begin = state.bodies;
  const MotionSet motions = work == nullptr ? MotionSet{} : motions_of(state);
  const WrenchSet first =
      by_rule([&](const WrenchRule& rule) { return rule.first_half(before, after); });
  half_kick(state, t_s, h_s, first, begin, Half::First);
  track_coordinates(state, h_s);
  const std::vector<BodyState> middle = state.bodies;
  if (work != nullptr) {
    work->add(sorted_, middle, h_s, 0.5);
    work->motors_J = work_J(sorted_.motors, begin, h_s);
    work->kinetic_loss_J = velocity_change_J(params_, begin, middle);
  }
  // Forces at the end need its velocities before they are known: 2 u − v is right to O(h²).
  for (std::size_t i = 0; i < begin.size(); ++i) {
    state.bodies[i].v_WB = 2.0 * middle[i].v_WB - begin[i].v_WB;
    state.bodies[i].w_WB = 2.0 * middle[i].w_WB - begin[i].w_WB;
  }
  const WrenchSet second =
      by_rule([&](const WrenchRule& rule) { return rule.second_half(before, after); });
  half_kick(state, t_s + h_s, h_s, second, middle, Half::Second);
  // The second half changes velocities alone.
  for (std::size_t i = 0; i < begin.size(); ++i) {
    state.bodies[i].p_WB = middle[i].p_WB;
    state.bodies[i].q_WB = middle[i].q_WB;
  }
  if (work == nullptr) return;
  work->add(sorted_, middle, h_s, 0.5);
  work->motors_J += work_J(sorted_.motors, state.bodies, h_s);
  work->kinetic_loss_J -= velocity_change_J(params_, middle, state.bodies);
  work->stand_in_J = stand_in_work_J(params_, begin, state.bodies, middle);
  const Eigen::VectorXd sum = stack(wrenches.begin) + stack(wrenches.end);
  const Eigen::VectorXd moved = difference(motions, motions_of(state));
  for (Eigen::Index i = 0; 6 * i < sum.size(); ++i) {
    work->interface_J += 0.5 * sum.segment<6>(6 * i).dot(moved.segment<6>(12 * i));
  }
}

void RigidWorld::half_kick(State& state, double t_s, double h_s, const WrenchSet& wrenches,
                           const std::vector<BodyState>& bodies, Half half) {
  std::vector<BodyWrench> applied(bodies.size());
  sorted_.reset(bodies.size());
  loads_.add_to(state, t_s, applied, sorted_);
  add_port_wrenches(state, wrenches, applied);
  add_gyroscopic_torques(state, applied);
  world_.load(bodies, state.joint_coordinates);
  const bool first = half == Half::First;
  command_motors(state, h_s, first ? MotorAim::Mean : MotorAim::End);
  const StepRule rule = first ? first_half(params_) : second_half(params_, h_s);
  world_.step(h_s, applied, rule);
  world_.read(state.bodies);
  record(h_s, rule, bodies, state.joint_coordinates, applied, state.bodies);
  world_.add_reactions(sorted_.motors, sorted_.joints);
}

void RigidWorld::add_gyroscopic_torques(const State& state, std::vector<BodyWrench>& applied) {
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    const Eigen::Quaterniond& q_WB = state.bodies[i].q_WB;
    const Eigen::Vector3d w_B = q_WB.conjugate() * state.bodies[i].w_WB;
    const Eigen::Vector3d torque = -(q_WB * w_B.cross(params_.bodies[i].inertia_B() * w_B));
    applied[i].t_B_W += torque;
    sorted_.gyroscopic[i].t_B_W = torque;
  }
}

void RigidWorld::command_motors(const State& state, double h_s, MotorAim aim) {
  const double t_s = to_seconds(state.time);
  for (std::size_t j = 0; j < params_.joints.size(); ++j) {
    const auto& motor = params_.joints[j].motor;
    if (!motor) continue;
    const auto axis = static_cast<std::size_t>(motor->axis - 1);
    const double coordinate = state.joint_coordinates[j][axis];
    world_.set_motor_speed(j, motor_rate(*motor, aim, coordinate, t_s, h_s, params_.erp));
  }
}

void RigidWorld::add_port_wrenches(const State& state, const WrenchSet& wrenches,
                                   std::vector<BodyWrench>& applied) {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    for (BodyWrench* on_body : {&applied[ports_[i].body], &sorted_.ports[ports_[i].body]}) {
      on_body->add_at(state.bodies[ports_[i].body].q_WB * ports_[i].p_BP, wrenches[i].f_P_W);
      on_body->t_B_W += wrenches[i].t_P_W;
    }
  }
}

void RigidWorld::track_coordinates(State& state, double h_s) const {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (std::size_t j = 0; j < params_.joints.size(); ++j) {
    std::array<double, 2> now = world_.coordinates(j);
    if (params_.joints[j].kind != JointKind::Slider) {
      // ODE measures an angle within one turn: meant is the nearest to where its rate has led.
      const std::array<double, 2> rates = world_.rates(j);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double expected = state.joint_coordinates[j][axis] + h_s * rates[axis];
        now[axis] += kTurn * std::round((expected - now[axis]) / kTurn);
      }
    }
    state.joint_coordinates[j] = now;
  }
}

double RigidWorld::kinetic_energy_J(const State& state) const {
  double energy = 0.0;
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    if (params_.bodies[i].massless) continue;
    const BodyState& body = state.bodies[i];
    const Eigen::Vector3d w_B = body.q_WB.conjugate() * body.w_WB;
    energy += 0.5 * (params_.bodies[i].mass_kg * body.v_WB.squaredNorm() +
                     w_B.dot(params_.bodies[i].inertia_B() * w_B));
  }
  return energy;
}

}  // namespace tandem::mbs
