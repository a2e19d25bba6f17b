#include "fem_process/ancf/beam_body.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "protocol/contract/error.h"

namespace tandem::fem::ancf {
namespace {

std::string at_time(SimTime time) {
  return fmt::format("fem: at t = {:.9g} s: ", to_seconds(time));
}

/// A torque that changes its sign in so many successive macro steps is no motion of the band: free
/// vibrations that fast are damped away, stick and slip change at random.
constexpr int kMostSwings = 20;

/// Torques below this part of the wheel's force times its radius are round-off.
constexpr double kNoTorque = 1e-6;

/// With more delay than a step between the sides the torque swings with four to six macro steps a
/// period, up to the friction limit: swings beyond this part of force times radius count.
constexpr double kLargeTorque = 0.05;
constexpr int kMostReversals = 60;

}  // namespace

BeamBody::BeamBody(BeamParams params)
    : params_(std::move(params)),
      attachments_(params_.model.mesh, params_.attachments),
      system_(params_.model),
      contact_(system_.mesh(), params_.model.section, params_.wheels, params_.grounds,
               params_.grid),
      step_(system_, contact_, params_.step, attachments_.empty() ? nullptr : &attachments_) {
  check_teeth(params_);
  info_.name = "fem";
  for (const std::string& name : params_.ports) info_.ports.push_back({name, 0.0});
  // The bending moment of a clamped end lives on the length of an element.
  for (const Attachment& end : params_.attachments) {
    const std::size_t element = end.at_end ? system_.mesh().elements.size() - 1 : 0;
    info_.ports[static_cast<std::size_t>(end.port)].length_m =
        system_.mesh().elements[element].length_m;
  }
  for (const Wheel& wheel : params_.wheels) {
    info_.ports[static_cast<std::size_t>(wheel.port)].length_m = wheel.radius_m;
  }
  if (!params_.follows_macro_step) info_.micro_step = params_.micro_step;
  info_.can_linearize = true;
}

WrenchSet BeamBody::initialize(const MotionSet& motions) {
  require(motions.size() == params_.ports.size(),
          fmt::format("fem: initialize: {} motions for {} ports.", motions.size(),
                      params_.ports.size()));
  require(all_finite(motions), "fem: initialize: the port motions must be finite.");
  check_overlap(params_, motions);
  now_ = {};
  now_.motions = motions;
  now_.swings.assign(params_.wheels.size(), 0);
  now_.reversals.assign(params_.wheels.size(), 0);
  BeamState& state = now_.state;
  state.q = system_.mesh().q0;
  state.v = state.a = state.A = Eigen::VectorXd::Zero(state.q.size());
  attachments_.take_places(motions, state.q);
  if (params_.settle.duration > SimTime{}) {
    settle(motions);
  } else {
    set_velocities();
  }
  attachments_.place(motions, state.q, state.v);
  if (!step_.balance(motions, state, now_.sums)) {
    throw Error(ErrorKind::NotSolved,
                at_time({}) +
                    "the accelerations at the start cannot be computed: an element is "
                    "turned inside out, or the mass matrix is singular.");
  }
  initialized_ = true;
  saved_ = now_;
  return now_.sums.wheels;
}

void BeamBody::settle(const MotionSet& motions) {
  MotionSet held = motions;
  for (Motion& motion : held) {
    motion.v_WP.setZero();
    motion.w_WP.setZero();
  }
  StepParams damped = params_.step;
  damped.mass_damping_per_s = params_.settle.mass_damping_per_s;
  damped.friction = false;
  const BeamStep step(system_, contact_, damped, attachments_.empty() ? nullptr : &attachments_);
  BeamState& state = now_.state;
  state.motions = held;
  state.wheels.resize(held.size());
  while (state.time < params_.settle.duration) {
    BeamStep::Result next = step.advance(state, {held, held}, params_.settle.step);
    if (next.outcome != Outcome::Done) {
      throw Error(ErrorKind::NotSolved,
                  fmt::format("fem: settling, {:.4g} s after its start: {} Shorten "
                              "fem.ancf.settle.step_s, or raise its mass_damping_per_s.",
                              to_seconds(state.time), next.message));
    }
    state = std::move(next.state);
  }
  state.time = {};
  state.v.setZero();
  state.matrix.reset();
  state.book = {};
}

void BeamBody::set_velocities() {
  const VelocityField& field = params_.velocity;
  BeamState& state = now_.state;
  for (const BeamElement& element : system_.mesh().elements) {
    for (const Term& term : element.terms) {
      if (system_.mesh().fixed[static_cast<std::size_t>(term.vector)]) continue;
      const Eigen::Vector3d x = state.q.segment<3>(3 * term.vector);
      const bool position = term.slot % 4 == 0;
      state.v.segment<3>(3 * term.vector) =
          position ? Eigen::Vector3d(field.linear_m_per_s +
                                     field.angular_rad_per_s.cross(x - field.about_m))
                   : Eigen::Vector3d(field.angular_rad_per_s.cross(x));
    }
  }
}

std::string BeamBody::count_swings(const ContactSums& before, Moment& after) const {
  std::string message;
  for (std::size_t w = 0; w < params_.wheels.size(); ++w) {
    const Wheel& wheel = params_.wheels[w];
    const auto port = static_cast<std::size_t>(wheel.port);
    const Eigen::Vector3d axis = after.motions[port].q_WP * Eigen::Vector3d::UnitY();
    const double last = before.wheels[port].t_P_W.dot(axis);
    const double now = after.sums.wheels[port].t_P_W.dot(axis);
    const double scale = wheel.radius_m * after.sums.wheels[port].f_P_W.norm();
    const bool changes = last * now < 0.0;
    const bool swings = changes && std::min(std::abs(last), std::abs(now)) > kNoTorque * scale;
    const bool large = changes && std::max(std::abs(last), std::abs(now)) > kLargeTorque * scale;
    after.swings[w] = swings ? after.swings[w] + 1 : 0;
    after.reversals[w] = std::max(0, after.reversals[w] + (large ? 2 : -1));
    const bool too_many = after.swings[w] >= kMostSwings || after.reversals[w] >= kMostReversals;
    if (!too_many || !message.empty()) continue;
    message = fmt::format(
        "the torque of the band on the wheel at port '{}' changes its sign every one to three "
        "macro steps, from {:.4g} to {:.4g} N m now: the step is beyond the stability limit of an "
        "explicit exchange of friction, about twice the wheel's spin inertia over v_s A R², less "
        "in parallel. Shorten run.macro_step_s, lower "
        "fem.ancf.contact.friction_slope_N_s_per_m3, or use coupling.scheme: interface_jacobian or "
        "implicit.",
        params_.ports[port], last, now);
  }
  return message;
}

SimTime BeamBody::micro_step_of(SimTime macro_step) const {
  return params_.follows_macro_step ? macro_step : params_.micro_step;
}

void BeamBody::check_request(const StepRequest<MotionSet>& request) const {
  require(initialized_, "fem: advance before initialize.");
  require(request.input.begin.size() == params_.ports.size() &&
              request.input.end.size() == params_.ports.size(),
          "fem: advance: one motion per port is needed at both ends of the step.");
  require(request.step > SimTime{} && request.step % micro_step_of(request.step) == SimTime{},
          fmt::format("fem: advance: the macro step of {} ns is not a whole multiple of the micro "
                      "step of {} ns. Change fem.micro_step_s.",
                      request.step.count(), params_.micro_step.count()));
}

StepResult<WrenchSet> BeamBody::advance(const StepRequest<MotionSet>& request) {
  check_request(request);
  const double begin_s = now_s();
  StepResult<WrenchSet> result;
  if (!all_finite(request.input.end) || !all_finite(request.input.begin)) {
    result.message = at_time(now_.state.time) + "the port motions are not finite.";
    return result;
  }
  const SimTime h = micro_step_of(request.step);
  const std::int64_t n = request.step / h;
  result.outcome = Outcome::Done;
  result.message.clear();
  Moment moment = now_;
  for (std::int64_t j = 1; j <= n; ++j) {
    const double s = static_cast<double>(j) / static_cast<double>(n);
    const MotionSet begin = std::move(moment.motions);
    moment.motions = interpolate(request.input, s, request.step);
    BeamStep::Result next =
        step_.advance(moment.state, {j == 1 ? request.input.begin : begin, moment.motions}, h);
    result.solver_iterations += next.iterations;
    effort_.iterations += next.iterations;
    effort_.factorisations += next.factorisations;
    effort_.halvings += next.halvings;
    if (next.outcome != Outcome::Done) {
      result.outcome = Outcome::Failed;
      result.message = at_time(moment.state.time + h) + next.message;
      break;
    }
    moment.state = std::move(next.state);
    moment.sums = std::move(next.sums);
  }
  if (result.outcome == Outcome::Done) {
    const std::string swings = count_swings(now_.sums, moment);
    if (!swings.empty()) {
      result.outcome = Outcome::Failed;
      result.message = at_time(moment.state.time) + swings;
    }
  }
  if (result.outcome == Outcome::Done) {
    now_ = std::move(moment);
    result.output = now_.sums.wheels;
    if (request.linearize && n == 1) {
      result.jacobian = step_.jacobian(now_.state, now_.motions, h);
    }
  }
  result.cost.compute_s = now_s() - begin_s;
  return result;
}

void BeamBody::checkpoint() {
  saved_ = now_;
  if (observer_) observer_(*this);
}

void BeamBody::rollback() { now_ = saved_; }

Observation BeamBody::observe() {
  const BeamState& state = now_.state;
  Observation seen;
  seen.time = state.time;
  StateHash hash;
  hash.add(state.hash());
  for (const std::vector<int>* counts : {&now_.swings, &now_.reversals}) {
    for (int count : *counts) hash.add(static_cast<std::int64_t>(count));
  }
  seen.state_hash = hash.value();
  seen.energy = state.book;
  seen.energy.kinetic_J = system_.kinetic_J(state.v);
  seen.energy.potential_J = system_.potential_J(state.q);
  seen.energy.elastic_J = system_.elastic_J(state.q) + now_.sums.stored_J;
  return seen;
}

BeamBody::PointMotion BeamBody::motion_of(const WatchPoint& point) const {
  const double length = system_.mesh().elements[static_cast<std::size_t>(point.element)].length_m;
  const auto s = shape_values(length, point.xi, 0.0, 0.0);
  return {system_.mesh().gather(point.element, now_.state.q) * s,
          system_.mesh().gather(point.element, now_.state.v) * s};
}

}  // namespace tandem::fem::ancf
