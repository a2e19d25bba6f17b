#pragma once

#include <cstdint>
#include <functional>

#include "protocol/contract/hash.h"
#include "protocol/contract/subsystem.h"

namespace tandem::test {

/// A flexible side that counts its calls and whose output depends on every call ever made: a call
/// that is lost, made twice or out of order changes all later values.
class CountingFem final : public FemSide {
 public:
  explicit CountingFem(std::size_t ports = 2) {
    info_ = {.name = "fem", .ports = {}, .micro_step = SimTime(1000000), .can_linearize = true};
    for (std::size_t i = 0; i < ports; ++i)
      info_.ports.push_back({std::string("p").append(std::to_string(i)), 0.25});
  }

  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }

  WrenchSet initialize(const MotionSet& input) override {
    state_ = {};
    return output(input);
  }

  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override {
    ++advances;
    if (on_advance) on_advance(advances);
    state_.memory = 0.75 * state_.memory + 0.125 * request.input.end.front().p_WP.x() +
                    0.0625 * request.input.begin.front().v_WP.z() + to_seconds(request.step);
    state_.time += request.step;
    StepResult<WrenchSet> result;
    result.outcome = Outcome::Done;
    result.message = "";
    result.output = output(request.input.end);
    result.solver_iterations = static_cast<std::int32_t>(advances);
    if (request.linearize) {
      const auto p = static_cast<Eigen::Index>(info_.ports.size());
      result.jacobian = Eigen::MatrixXd::Constant(6 * p, 12 * p, state_.memory);
    }
    return result;
  }

  void checkpoint() override {
    ++checkpoints;
    saved_ = state_;
  }
  void rollback() override {
    ++rollbacks;
    state_ = saved_;
  }

  Observation observe() override {
    StateHash hash;
    hash.add(state_.memory);
    hash.add(static_cast<std::int64_t>(state_.time.count()));
    return {.time = state_.time,
            .energy = {.kinetic_J = 1.0,
                       .potential_J = -2.0,
                       .elastic_J = state_.memory,
                       .external_work_J = 0.1},
            .state_hash = hash.value()};
  }

  std::int64_t advances = 0;
  std::int64_t checkpoints = 0;
  std::int64_t rollbacks = 0;
  std::function<void(std::int64_t)> on_advance;  ///< e.g. to throw or to sleep

 private:
  struct State {
    double memory = 1.0;
    SimTime time{};
  };
  WrenchSet output(const MotionSet& input) const {
    WrenchSet wrenches(info_.ports.size());
    for (std::size_t i = 0; i < wrenches.size(); ++i) {
      const double scale = state_.memory / static_cast<double>(i + 1);
      wrenches[i].f_P_W = scale * input.at(i).p_WP;
      wrenches[i].t_P_W = Eigen::Vector3d(scale, -0.0, input.at(i).q_WP.z());
    }
    return wrenches;
  }

  SubsystemInfo info_;
  State state_;
  State saved_;
};

/// Motions that differ in every number.
inline MotionSet some_motions(std::size_t ports, double seed) {
  MotionSet motions(ports);
  for (std::size_t i = 0; i < ports; ++i) {
    const double x = seed + 0.1 * static_cast<double>(i);
    motions[i].p_WP = {x, x + 0.01, x + 0.02};
    motions[i].q_WP = Eigen::Quaterniond(0.5, -0.5, 0.5, x);
    motions[i].v_WP = {-x, 2.0 * x, x * x};
    motions[i].w_WP = {x / 3.0, x / 7.0, -x / 11.0};
  }
  return motions;
}

/// Drives `fem` through macro steps of `iterations` advances each, as an implicit scheme does, and
/// returns a hash of every bit that came back.
inline std::uint64_t drive(FemSide& fem, int macro_steps, int iterations) {
  StateHash hash;
  const auto add = [&](const WrenchSet& wrenches) {
    for (const Wrench& wrench : wrenches) {
      hash.add({wrench.f_P_W.data(), 3});
      hash.add({wrench.t_P_W.data(), 3});
    }
  };
  MotionSet begin = some_motions(fem.info().ports.size(), 0.5);
  add(fem.initialize(begin));
  for (int step = 1; step <= macro_steps; ++step) {
    fem.checkpoint();
    for (int k = 1; k <= iterations; ++k) {
      if (k > 1) fem.rollback();
      const MotionSet end = some_motions(begin.size(), 0.01 * step + 0.001 * k);
      const auto result = fem.advance(
          {.step = SimTime(1000000), .input = {begin, end}, .linearize = k == iterations});
      add(result.output);
      if (result.jacobian) hash.add((*result.jacobian)(0, 0));
      if (k == iterations) begin = end;
    }
  }
  fem.checkpoint();
  hash.add(static_cast<std::int64_t>(fem.observe().state_hash));
  return hash.value();
}

}  // namespace tandem::test
