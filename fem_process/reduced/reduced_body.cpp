#include "fem_process/reduced/reduced_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "fem_process/body/held.h"
#include "fem_process/ports/macro_step_wrench.h"
#include "fem_process/reduced/reduced_tangent.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

std::string at_time(SimTime time) {
  return "fem: at t = " + fmt::format("{:.6g}", to_seconds(time)) + " s: ";
}

}  // namespace

ReducedBody::ReducedBody(Params params)
    : model_(std::move(params)), modes_(fixed_boundary_modes(model_, model_.params.craig_bampton)) {
  static_cast<void>(frame_weights(model_));  // must exist
  if (!model_.integrator->inertia()) require_held(model_);
  info_.name = "fem";
  for (const Model::Port& port : model_.ports) info_.ports.push_back({port.name, port.length_m});
  if (!model_.params.follows_macro_step) info_.micro_step = model_.params.micro_step;
  info_.can_linearize = true;
}

WrenchSet ReducedBody::initialize(const MotionSet& motions) {
  require(motions.size() == model_.ports.size(),
          "fem: initialize: " + std::to_string(motions.size()) + " motions for " +
              std::to_string(model_.ports.size()) + " ports.");
  require(all_finite(motions), "fem: initialize: the port motions must be finite.");
  step_.reset();
  reduced_.emplace(model_, modes_, motions);
  step_.emplace(*reduced_);
  state_ = ReducedState{};
  WrenchSet wrenches;
  step_->start(motions, state_, wrenches);
  state_.turned_rad = reduced_->elastic_turn().largest_rad(state_.z);
  saved_ = state_;
  return wrenches;
}

namespace {

void take_about(const MotionSet& from, const MotionSet& to, WrenchSet& wrenches) {
  for (std::size_t p = 0; p < wrenches.size(); ++p) {
    wrenches[p].t_P_W += (from[p].p_WP - to[p].p_WP).cross(wrenches[p].f_P_W);
  }
}

/// The derivative of what take_about() makes of a micro step's wrenches, which begins at `s`.
InterfaceJacobian about_begin(const StepRequest<MotionSet>& request, double s, VelocityRule rule,
                              const WrenchSet& wrenches, InterfaceJacobian jacobian) {
  const MotionSet from = interpolate(request.input, s, request.step, rule);
  const auto derivative = interpolation_derivative(request.input, s, request.step, rule);
  for (std::size_t p = 0; p < wrenches.size(); ++p) {
    const auto row = 6 * static_cast<Eigen::Index>(p);
    const auto column = 12 * static_cast<Eigen::Index>(p);
    const Eigen::Vector3d arm = from[p].p_WP - request.input.begin[p].p_WP;
    for (Eigen::Index c = 0; c < jacobian.cols(); ++c) {
      jacobian.col(c).segment<3>(row + 3) +=
          arm.cross(Eigen::Vector3d(jacobian.col(c).segment<3>(row)));
    }
    for (Eigen::Index c = 0; c < 12; ++c) {
      jacobian.col(column + c).segment<3>(row + 3) +=
          Eigen::Vector3d(derivative[p].col(c).head<3>()).cross(wrenches[p].f_P_W);
    }
  }
  return jacobian;
}

}  // namespace

void ReducedBody::run(const StepRequest<MotionSet>& request, StepResult<WrenchSet>& result) {
  const SimTime h = model_.params.follows_macro_step ? request.step : model_.params.micro_step;
  const std::int64_t n = request.step / h;
  const VelocityRule rule = velocity_rule(*model_.integrator);
  MacroStepWrench answer(*model_.integrator, n);
  ReducedTangent tangent(*reduced_);
  // Torques of forces that act constantly are about the ports' origins at the beginning of the
  // macro step, those of a micro step about where they are at its own.
  const bool moves = model_.integrator->constant_forces();
  ReducedState state = state_;
  for (std::int64_t j = 1; j <= n; ++j) {
    const double s = static_cast<double>(j) / static_cast<double>(n);
    ReducedStep::Result step =
        step_->advance(state, interpolate(request.input, s, request.step, rule), h);
    if (step.report.outcome == Outcome::Failed) {
      result.message = at_time(state.time + h) + step.report.message;
      return;
    }
    if (request.linearize) {
      tangent.advance(state, interpolation_derivative(request.input, s, request.step, rule), step);
      answer.add(j > 1 && moves
                     ? about_begin(request, static_cast<double>(j - 1) / static_cast<double>(n),
                                   rule, step.wrenches, tangent.jacobian())
                     : tangent.jacobian());
    }
    if (j > 1 && moves) take_about(state.ports, request.input.begin, step.wrenches);
    step.state.turned_rad =
        std::max(state.turned_rad, reduced_->elastic_turn().largest_rad(step.state.z));
    state = std::move(step.state);
    answer.add(step.wrenches);
  }
  result.output = answer.wrenches();
  if (!state.z.allFinite() || !all_finite(result.output)) {
    result.message = at_time(state.time) +
                     "modal coordinates or wrenches are not finite. Check the port motions, or "
                     "shorten fem.micro_step_s.";
    return;
  }
  result.outcome = Outcome::Done;
  result.message.clear();
  if (request.linearize) result.jacobian = answer.jacobian();
  state_ = std::move(state);
}

StepResult<WrenchSet> ReducedBody::advance(const StepRequest<MotionSet>& request) {
  require(step_.has_value(), "fem: advance before initialize.");
  require(request.input.begin.size() == model_.ports.size() &&
              request.input.end.size() == model_.ports.size(),
          "fem: advance: one motion per port is needed at both ends of the step.");
  require(request.step > SimTime{} && (model_.params.follows_macro_step ||
                                       request.step % model_.params.micro_step == SimTime{}),
          "fem: advance: the macro step of " + std::to_string(request.step.count()) +
              " ns is not a whole multiple of the micro step of " +
              std::to_string(model_.params.micro_step.count()) + " ns. Change fem.micro_step_s.");
  const double begin_s = now_s();
  StepResult<WrenchSet> result;
  if (all_finite(request.input.begin) && all_finite(request.input.end)) {
    run(request, result);
  } else {
    result.message = at_time(state_.time) + "the port motions are not finite.";
  }
  result.cost.compute_s = now_s() - begin_s;
  return result;
}

void ReducedBody::checkpoint() {
  saved_ = state_;
  if (observer_) observer_(nodal_state());
}

void ReducedBody::rollback() { state_ = saved_; }

State ReducedBody::nodal_state() const {
  const auto fields = reduced_->fields();
  State nodal;
  nodal.time = state_.time;
  nodal.x = reduced_->expand(Eigen::Map<const FieldMotion>(state_.fields.x.data(), 3, fields));
  nodal.v = reduced_->expand(Eigen::Map<const FieldMotion>(state_.fields.v.data(), 3, fields));
  nodal.book = state_.book;
  return nodal;
}

Observation ReducedBody::observe() {
  const auto fields = reduced_->fields();
  const Eigen::Map<const FieldMotion> Y(state_.fields.x.data(), 3, fields);
  const Eigen::Map<const FieldMotion> V(state_.fields.v.data(), 3, fields);
  Observation seen;
  seen.time = state_.time;
  seen.state_hash = state_.hash();
  seen.energy = state_.book;
  seen.elastic_turn_rad = state_.turned_rad;
  if (model_.integrator->inertia()) {
    seen.energy.kinetic_J = 0.5 * (V * reduced_->T()).cwiseProduct(V).sum();
  }
  const auto zeta = state_.z.head(reduced_->boundary());
  seen.energy.elastic_J = 0.5 * (zeta.dot(reduced_->K_boundary() * zeta) +
                                 reduced_->omega2().dot(state_.modal.x.cwiseAbs2()));
  seen.energy.potential_J = -reduced_->gravity().cwiseProduct(Y).sum();
  return seen;
}

}  // namespace tandem::fem
