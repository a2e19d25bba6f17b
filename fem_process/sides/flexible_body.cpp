#include "fem_process/sides/flexible_body.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "fem_process/body/held.h"
#include "fem_process/ports/macro_step_wrench.h"
#include "fem_process/transient/step_energy.h"
#include "fem_process/turning/elastic_turn.h"
#include "fem_process/turning/middle_carry.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

PortArms port_arms(const Model& model, const MotionSet& motions) {
  PortArms arms;
  for (std::size_t p = 0; p < model.ports.size(); ++p) {
    std::vector<Eigen::Vector3d>& port = arms.emplace_back();
    for (int node : model.ports[p].nodes) {
      port.push_back(motions[p].q_WP.conjugate() *
                     (model.mesh.X[static_cast<std::size_t>(node)] - motions[p].p_WP));
    }
  }
  return arms;
}

std::string at_time(SimTime time) {
  return "fem: at t = " + fmt::format("{:.6g}", to_seconds(time)) + " s: ";
}

}  // namespace

FlexibleBody::FlexibleBody(Params params) : model_(std::move(params)) {
  if (!model_.integrator->inertia()) require_held(model_);
  info_.name = "fem";
  for (const Model::Port& port : model_.ports) info_.ports.push_back({port.name, port.length_m});
  if (!model_.params.follows_macro_step) info_.micro_step = model_.params.micro_step;
  info_.can_linearize = true;
  held_ = names_of(model_.params.fixed);
  check_changes();
}

WrenchSet FlexibleBody::initialize(const MotionSet& motions) {
  require(motions.size() == model_.ports.size(),
          "fem: initialize: " + std::to_string(motions.size()) + " motions for " +
              std::to_string(model_.ports.size()) + " ports.");
  require(all_finite(motions), "fem: initialize: the port motions must be finite.");
  arms_ = port_arms(model_, motions);
  step_.reset();
  hold(names_of(model_.params.fixed));
  state_ = State{};
  state_.boundary.fixed = held_;
  WrenchSet wrenches;
  const SolveReport report = step_->start(motions, state_, wrenches);
  if (report.outcome != Outcome::Done) {
    throw Error(ErrorKind::NotSolved, at_time({}) + "initial state: " + report.message);
  }
  state_.generation = ++generations_;
  saved_ = state_;
  return wrenches;
}

SimTime FlexibleBody::micro_step_of(SimTime macro_step) const {
  return model_.params.follows_macro_step ? macro_step : model_.params.micro_step;
}

void FlexibleBody::check_request(const StepRequest<MotionSet>& request) const {
  require(step_.has_value(), "fem: advance before initialize.");
  require(request.input.begin.size() == model_.ports.size() &&
              request.input.end.size() == model_.ports.size(),
          "fem: advance: one motion per port is needed at both ends of the step.");
  require(request.step > SimTime{} && request.step % micro_step_of(request.step) == SimTime{},
          "fem: advance: the macro step of " + std::to_string(request.step.count()) +
              " ns is not a whole multiple of the micro step of " +
              std::to_string(model_.params.micro_step.count()) + " ns. Change fem.micro_step_s.");
}

FlexibleBody::Advance FlexibleBody::run(const StepRequest<MotionSet>& request) {
  const SimTime h = micro_step_of(request.step);
  const std::int64_t n = request.step / h;
  const VelocityRule rule = velocity_rule(*model_.integrator);
  MacroStepWrench answer(*model_.integrator, n);
  Advance done;
  done.last.state = state_;
  StepTangent tangent(model_, *step_, n);
  const auto book = [&](const SolveReport& report, SimTime time) {
    done.report.iterations += report.iterations;
    if (report.outcome <= done.report.outcome) return;
    done.report.outcome = report.outcome;
    done.report.message = at_time(time) + report.message;
  };
  for (std::int64_t j = 1; j <= n && done.report.outcome != Outcome::Failed; ++j) {
    const double s = static_cast<double>(j) / static_cast<double>(n);
    const MotionSet end = interpolate(request.input, s, request.step, rule);
    Linearisation& kept = kept_[j == 1 ? 0 : 1];
    if (j > 1 && step_->shares_factor()) kept.neighbour = &kept_[0];
    const State from = std::move(done.last.state);
    done.last = step_->advance(from, end, request.input.begin, h, kept);
    done.last.state.generation = ++generations_;
    book(done.last.report, from.time + h);
    done.report.residual = std::max(done.report.residual, done.last.report.residual);
    answer.add(done.last.wrenches);
    if (!request.linearize || done.report.outcome == Outcome::Failed) continue;
    book(
        tangent.advance(from, {end, interpolation_derivative(request.input, s, request.step, rule)},
                        request.input.begin, done.last, kept),
        from.time + h);
    answer.add(tangent.jacobian());
  }
  if (done.report.outcome == Outcome::Failed) return done;
  done.last.wrenches = answer.wrenches();
  if (!done.last.state.x.allFinite() || !all_finite(done.last.wrenches)) {
    book({.outcome = Outcome::Failed,
          .message = "positions or wrenches are not finite. Check the port motions, or shorten "
                     "fem.micro_step_s."},
         state_.time + request.step);
  }
  if (request.linearize) done.jacobian = answer.jacobian();
  return done;
}

StepResult<WrenchSet> FlexibleBody::advance(const StepRequest<MotionSet>& request) {
  check_request(request);
  const double begin_s = now_s();
  StepResult<WrenchSet> result;
  if (!all_finite(request.input.end) || !all_finite(request.input.begin)) {
    result.message = at_time(state_.time) + "the port motions are not finite.";
    return result;
  }
  Advance done = run(request);
  result.outcome = done.report.outcome;
  result.message = done.report.message;
  result.solver_iterations = done.report.iterations;
  // The resultant of the forces that are left over on N nodes: at most √N times their norm.
  result.output_error_N = std::sqrt(static_cast<double>(model_.free.size())) * done.report.residual;
  if (result.outcome != Outcome::Failed) {
    result.output = std::move(done.last.wrenches);
    if (request.linearize) result.jacobian = std::move(done.jacobian);
    state_ = std::move(done.last.state);
  }
  result.cost.compute_s = now_s() - begin_s;
  return result;
}

void FlexibleBody::checkpoint() {
  make_scheduled_changes();
  note_chords();
  saved_ = state_;
  if (observer_) observer_(state_);
}

/// Over micro steps ports are led along the curve that joins the ends: those are no chords.
void FlexibleBody::note_chords() {
  if (model_.integrator->keeps_history()) return;
  const SimTime H = state_.time - saved_.time;
  if (H <= SimTime{} || saved_.port_motions.size() != state_.port_motions.size()) return;
  const bool one_step = info_.micro_step == SimTime{} || info_.micro_step == H;
  state_.port_chords = port_chords(saved_.port_motions, state_.port_motions, to_seconds(H));
  if (!one_step) state_.port_chords.setZero();
}

void FlexibleBody::rollback() {
  state_ = saved_;
  if (state_.boundary.fixed != held_) hold(state_.boundary.fixed);
}

Observation FlexibleBody::observe() {
  Observation seen;
  seen.time = state_.time;
  seen.state_hash = state_.hash();
  seen.energy = state_.book;
  seen.energy.kinetic_J = kinetic_energy_J(model_, state_.v);
  seen.energy.elastic_J = model_.formulation->energy(state_.x) + state_.bushing_J;
  for (int i = 0; i < model_.mesh.nodes(); ++i) {
    seen.energy.potential_J -= model_.nodal_mass[static_cast<std::size_t>(i)] *
                               model_.params.gravity_m_per_s2.dot(state_.x.segment<3>(3 * i));
  }
  if (model_.params.formulation == FormulationKind::Linear) {
    seen.elastic_turn_rad = largest_turn_rad(model_.mesh, state_.x);
  }
  return seen;
}

}  // namespace tandem::fem
