#pragma once

#include <type_traits>
#include <utility>

#include "protocol/wire/remote_link.h"

namespace tandem::wire {

/// A side that lives in another process. checkpoint() and rollback() are flags that ride on the
/// next request, rollback before checkpoint; call observe() last, so that the last checkpoint()
/// gets across.
template <class In, class Out>
class RemoteSide final : public Subsystem<In, Out> {
 public:
  /// Connects; see RemoteLink::connect().
  RemoteSide(Bus& bus, LivenessMonitor& monitor, const RemoteOptions& options)
      : link_(bus, monitor, options) {
    const Handshake welcome = link_.connect();
    info_ = {.name = text_of(options.side),
             .ports = welcome.ports,
             .micro_step = welcome.micro_step,
             .can_linearize = welcome.can_linearize};
  }

  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }

  Out initialize(const In& input) override {
    Request request = make(RequestKind::Initialize);
    inputs(request).end = input;
    CallCost cost;
    return outputs(link_.call(request, cost));
  }

  StepResult<Out> advance(const StepRequest<In>& step) override {
    ++iteration_;
    Request request = make(RequestKind::Advance);
    request.step = step.step;
    request.linearize = step.linearize;
    inputs(request) = step.input;
    StepResult<Out> result;
    Reply reply = link_.call(request, result.cost);
    result.outcome = reply.outcome;
    result.message = std::move(reply.message);
    result.output = outputs(std::move(reply));
    result.jacobian = std::move(reply.jacobian);
    result.solver_iterations = reply.solver_iterations;
    return result;
  }

  void checkpoint() override {
    checkpoint_first_ = true;
    ++macro_step_;
    iteration_ = 0;
  }

  // Right after a checkpoint the state is the saved one already.
  void rollback() override { rollback_first_ = rollback_first_ || !checkpoint_first_; }

  Observation observe() override {
    Request request = make(RequestKind::Observe);
    CallCost cost;
    return link_.call(request, cost).observation;
  }

  /// Ends the serving process. Call it when the run is done.
  void close() { link_.bye(); }

  /// What all calls have cost, initialize and observe included.
  [[nodiscard]] const CallCost& total_cost() const { return link_.total(); }

 private:
  Request make(RequestKind kind) {
    Request request;
    request.call = kind;
    request.checkpoint_first = std::exchange(checkpoint_first_, false);
    request.rollback_first = std::exchange(rollback_first_, false);
    request.header.macro_step = macro_step_;
    request.header.iteration = iteration_;
    return request;
  }

  static Segment<In>& inputs(Request& request) {
    if constexpr (std::is_same_v<In, WrenchSet>) {
      return request.wrenches;
    } else {
      return request.motions;
    }
  }
  static Out&& outputs(Reply&& reply) {
    if constexpr (std::is_same_v<Out, WrenchSet>) {
      return std::move(reply.wrenches);
    } else {
      return std::move(reply.motions);
    }
  }

  RemoteLink link_;
  SubsystemInfo info_;
  bool checkpoint_first_ = false;
  bool rollback_first_ = false;
  std::int64_t macro_step_ = 0;
  std::int32_t iteration_ = 0;
};

using RemoteMbs = RemoteSide<WrenchSet, MotionSet>;
using RemoteFem = RemoteSide<MotionSet, WrenchSet>;

}  // namespace tandem::wire
