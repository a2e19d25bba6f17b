#include "fem_process/flexible_body.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocol/contract/error.h"
#include "protocol/contract/segment.h"

namespace tandem::fem {
namespace {

/// Motion with one of its 12 coordinates (see difference()) changed by `amount`.
Motion nudged(Motion motion, int coordinate, double amount) {
  const Eigen::Vector3d change = amount * Eigen::Vector3d::Unit(coordinate % 3);
  switch (coordinate / 3) {
    case 0:
      motion.p_WP += change;
      break;
    case 1:
      motion.q_WP = Eigen::Quaterniond(Eigen::AngleAxisd(amount, change / amount)) * motion.q_WP;
      break;
    case 2:
      motion.v_WP += change;
      break;
    default:
      motion.w_WP += change;
  }
  return motion;
}

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
  return "fem: at t = " + std::to_string(to_seconds(time)) + " s: ";
}

}  // namespace

FlexibleBody::FlexibleBody(Params params) : model_(std::move(params)) {
  info_.name = "fem";
  for (const Model::Port& port : model_.ports) info_.ports.push_back({port.name, port.length_m});
  info_.micro_step = model_.params.micro_step;
  info_.can_linearize = true;
}

WrenchSet FlexibleBody::initialize(const MotionSet& motions) {
  require(motions.size() == model_.ports.size(),
          "fem: initialize: " + std::to_string(motions.size()) + " motions for " +
              std::to_string(model_.ports.size()) + " ports.");
  require(all_finite(motions), "fem: initialize: the port motions must be finite.");
  step_.emplace(model_, port_arms(model_, motions));
  state_ = State{};
  WrenchSet wrenches;
  const SolveReport report = step_->start(motions, state_, wrenches);
  if (report.outcome != Outcome::Done) {
    throw Error(ErrorKind::NotSolved, at_time({}) + "initial accelerations: " + report.message);
  }
  state_.generation = ++generations_;
  saved_ = state_;
  return wrenches;
}

void FlexibleBody::check_request(const StepRequest<MotionSet>& request) const {
  require(step_.has_value(), "fem: advance before initialize.");
  require(request.input.begin.size() == model_.ports.size() &&
              request.input.end.size() == model_.ports.size(),
          "fem: advance: one motion per port is needed at both ends of the step.");
  require(request.step > SimTime{} && request.step % model_.params.micro_step == SimTime{},
          "fem: advance: the macro step of " + std::to_string(request.step.count()) +
              " ns is not a whole multiple of the micro step of " +
              std::to_string(model_.params.micro_step.count()) + " ns. Change fem.micro_step_s.");
}

FlexibleBody::Advance FlexibleBody::run(const StepRequest<MotionSet>& request, const State& begin) {
  const SimTime h = model_.params.micro_step;
  const std::int64_t n = request.step / h;
  Advance done;
  done.last.state = begin;
  for (std::int64_t j = 1; j <= n; ++j) {
    const double s = static_cast<double>(j) / static_cast<double>(n);
    const MotionSet end = j == n ? request.input.end : interpolate(request.input, s, request.step);
    const State from = std::move(done.last.state);
    done.last = step_->advance(from, end, h, kept_[j == 1 ? 0 : 1]);
    const SolveReport& report = done.last.report;
    done.report.iterations += report.iterations;
    if (report.outcome > done.report.outcome) {
      done.report.outcome = report.outcome;
      done.report.message = at_time(from.time + h) + report.message;
    }
    if (report.outcome == Outcome::Failed) return done;
    done.last.state.generation = ++generations_;
  }
  if (!done.last.state.x.allFinite() || !all_finite(done.last.wrenches)) {
    done.report.outcome = Outcome::Failed;
    done.report.message = at_time(begin.time + request.step) +
                          "positions or wrenches are not finite. Check the port motions, or " +
                          "shorten fem.micro_step_s.";
  }
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
  Advance done = run(request, state_);
  SolveReport derivative;
  InterfaceJacobian jacobian;
  if (request.linearize && done.report.outcome != Outcome::Failed) {
    derivative = linearize(request, done, jacobian);
  }
  result.outcome = std::max(done.report.outcome, derivative.outcome);
  result.message = done.report.message + derivative.message;
  result.solver_iterations = done.report.iterations + derivative.iterations;
  if (result.outcome != Outcome::Failed) {
    result.output = std::move(done.last.wrenches);
    if (request.linearize) result.jacobian = std::move(jacobian);
    state_ = std::move(done.last.state);
  }
  result.cost.compute_s = now_s() - begin_s;
  return result;
}

SolveReport FlexibleBody::linearize(const StepRequest<MotionSet>& request, const Advance& done,
                                    InterfaceJacobian& jacobian) {
  if (request.step == model_.params.micro_step) {
    return step_->linearize(request.input.end, done.last, kept_[0], jacobian);
  }
  return difference_quotients(request, jacobian);
}

/// Several micro steps: the end motion acts through all of them and through the stiffness between
/// them. Central differences of the whole macro step, 24 advances per port.
SolveReport FlexibleBody::difference_quotients(const StepRequest<MotionSet>& request,
                                               InterfaceJacobian& jacobian) {
  const auto ports = static_cast<Eigen::Index>(model_.ports.size());
  jacobian.resize(6 * ports, 12 * ports);
  SolveReport total;
  for (Eigen::Index column = 0; column < 12 * ports; ++column) {
    const auto port = static_cast<std::size_t>(column / 12);
    const int coordinate = static_cast<int>(column % 12);
    // 1e-5 of the length, angle or rate that changes the wrench by its own size.
    const double size = coordinate / 3 == 0 ? model_.ports[port].length_m : 1.0;
    const double amount = 1e-5 * size;
    Eigen::VectorXd ends[2];
    for (int side = 0; side < 2; ++side) {
      StepRequest<MotionSet> varied = request;
      varied.input.end[port] =
          nudged(request.input.end[port], coordinate, side == 0 ? -amount : amount);
      const Advance done = run(varied, state_);
      total.iterations += done.report.iterations;
      if (done.report.outcome != Outcome::Done) {
        return {done.report.outcome, done.report.message, total.iterations};
      }
      ends[side] = stack(done.last.wrenches);
    }
    jacobian.col(column) = (ends[1] - ends[0]) / (2.0 * amount);
  }
  return total;
}

void FlexibleBody::checkpoint() {
  saved_ = state_;
  if (observer_) observer_(state_);
}

void FlexibleBody::rollback() { state_ = saved_; }

Observation FlexibleBody::observe() {
  Observation seen;
  seen.time = state_.time;
  seen.state_hash = state_.hash();
  seen.energy.kinetic_J =
      0.5 * state_.v.dot(multiply_scalar(model_.pattern(), model_.mass, state_.v));
  seen.energy.elastic_J = model_.formulation->energy(state_.x);
  for (int i = 0; i < model_.mesh.nodes(); ++i) {
    seen.energy.potential_J -= model_.nodal_mass[static_cast<std::size_t>(i)] *
                               model_.params.gravity_m_per_s2.dot(state_.x.segment<3>(3 * i));
  }
  seen.energy.external_work_J = state_.external_work_J;
  return seen;
}

MeanMotion FlexibleBody::mean_motion(const std::string& node_set) const {
  const NodeSet& set = find_set(model_.mesh, {.name = node_set});
  MeanMotion mean;
  for (int node : set.nodes) {
    mean.position_m += state_.x.segment<3>(3 * node);
    mean.displacement_m +=
        state_.x.segment<3>(3 * node) - model_.mesh.X[static_cast<std::size_t>(node)];
    mean.velocity_m_per_s += state_.v.segment<3>(3 * node);
  }
  const auto n = static_cast<double>(set.nodes.size());
  return {mean.displacement_m / n, mean.position_m / n, mean.velocity_m_per_s / n};
}

}  // namespace tandem::fem
