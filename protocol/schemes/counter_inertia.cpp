#include "protocol/schemes/counter_inertia.h"

#include <algorithm>

#include "protocol/contract/hash.h"
#include "protocol/schemes/prediction.h"

namespace tandem {
namespace {

using Vector6 = Eigen::Vector<double, 6>;

Vector6 inertia_of(const StandInInertia& inertia) {
  Vector6 m;
  m << Eigen::Vector3d::Constant(inertia.mass_kg), Eigen::Vector3d::Constant(inertia.inertia_kg_m2);
  return m;
}

}  // namespace

CounterInertia::CounterInertia(FemSide& inner, const std::vector<PortInfo>& ports) : inner_(inner) {
  for (std::size_t p = 0; p < ports.size(); ++p) {
    if (ports[p].stand_in.mass_kg > 0.0) junctions_.push_back({p, ports[p].stand_in});
  }
}

bool CounterInertia::needed(const std::vector<PortInfo>& ports) {
  return std::any_of(ports.begin(), ports.end(),
                     [](const PortInfo& port) { return port.stand_in.mass_kg > 0.0; });
}

WrenchSet CounterInertia::initialize(const MotionSet& motions) {
  state_ = {.acceleration = std::vector<Vector6>(junctions_.size(), Vector6::Zero()),
            .wrench = std::vector<Vector6>(junctions_.size(), Vector6::Zero())};
  saved_ = state_;
  return inner_.initialize(motions);
}

StepResult<WrenchSet> CounterInertia::advance(const StepRequest<MotionSet>& request) {
  StepResult<WrenchSet> result = inner_.advance(request);
  add(request, result);
  return result;
}

void CounterInertia::begin_advance(const StepRequest<MotionSet>& request) {
  begun_ = request;
  inner_.begin_advance(request);
}

StepResult<WrenchSet> CounterInertia::finish_advance() {
  StepResult<WrenchSet> result = inner_.finish_advance();
  add(begun_, result);
  return result;
}

void CounterInertia::add(const StepRequest<MotionSet>& request, StepResult<WrenchSet>& result) {
  if (result.outcome == Outcome::Failed) return;
  const double H_s = to_seconds(request.step);
  result.own = result.output;
  const Eigen::VectorXd change = twists(request.input.end) - twists(request.input.begin);
  const Eigen::VectorXd moved = difference(request.input.begin, request.input.end);
  for (std::size_t j = 0; j < junctions_.size(); ++j) {
    const auto& [port, inertia] = junctions_[j];
    const double gamma = inertia.gamma, alpha_m = inertia.alpha_m, alpha_f = inertia.alpha_f;
    const Vector6 m = inertia_of(inertia);
    Vector6& a = state_.acceleration[j];
    Vector6& w = state_.wrench[j];
    const Vector6 mean = change.segment<6>(6 * static_cast<Eigen::Index>(port)) / H_s;
    const Vector6 before = w;
    const Vector6 end = (mean - (1.0 - gamma) * a) / gamma;
    w = (m.cwiseProduct((1.0 - alpha_m) * end + alpha_m * a) - alpha_f * w) / (1.0 - alpha_f);
    a = end;
    if (gamma < 1.0) {
      const Vector6 way = moved.segment<6>(12 * static_cast<Eigen::Index>(port));
      state_.work_J += (0.5 * (before + w) - m.cwiseProduct(mean)).dot(way);
    }
    result.output[port].f_P_W += w.head<3>();
    result.output[port].t_P_W += w.tail<3>();
    if (!result.jacobian) continue;
    const double share = (1.0 - alpha_m) / ((1.0 - alpha_f) * gamma * H_s);
    const auto row = 6 * static_cast<Eigen::Index>(port);
    result.jacobian->block<6, 6>(row, 2 * row + 6).diagonal() += share * m;
  }
}

void CounterInertia::checkpoint() {
  inner_.checkpoint();
  saved_ = state_;
}

void CounterInertia::rollback() {
  inner_.rollback();
  state_ = saved_;
}

Observation CounterInertia::observe() {
  Observation observation = inner_.observe();
  StateHash hash;
  hash.add(observation.state_hash);
  for (const std::vector<Vector6>* kept : {&state_.acceleration, &state_.wrench}) {
    for (const Vector6& value : *kept) {
      for (const double x : value) hash.add(x);
    }
  }
  observation.state_hash = hash.value();
  observation.energy.interface_work_J -= state_.work_J;
  observation.energy.numerical_loss_J -= state_.work_J;
  return observation;
}

}  // namespace tandem
