#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "protocol/wire/remote_link.h"
#include "protocol/wire/remote_links.h"

namespace tandem::wire {

/// A side that lives in another process. checkpoint() and rollback() are flags that ride on the
/// next request, rollback before checkpoint; call observe() last, so that the last checkpoint()
/// gets across.
template <class In, class Out>
class RemoteSide final : public Subsystem<In, Out>, public TimedCalls {
 public:
  /// Connects; see RemoteLink::connect(). `links`: those to the others of several bodies.
  RemoteSide(Bus& bus, LivenessMonitor& monitor, const RemoteOptions& options,
             RemoteLinks* links = nullptr)
      : link_(bus, monitor, options) {
    const Handshake welcome = link_.connect();
    info_ = {.name = bus.name_of(options.side),
             .ports = welcome.ports,
             .micro_step = welcome.micro_step,
             .can_linearize = welcome.can_linearize};
    if (links != nullptr) links->add(link_);
  }

  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }

  Out initialize(const In& input) override {
    Request head = make(RequestKind::Initialize);
    CallCost cost;
    return outputs(link_.call(view(head, {}, input), cost));
  }

  StepResult<Out> advance(const StepRequest<In>& step) override {
    begin_advance(step);
    return finish_advance();
  }

  void begin_advance(const StepRequest<In>& step) override {
    ++iteration_;
    Request head = make(RequestKind::Advance);
    head.step = step.step;
    head.linearize = step.linearize;
    // Where the last accepted segment ended: the side still has it.
    const bool known = link_.is_accepted(step.input.begin);
    link_.begin(view(head, known ? none() : step.input.begin, step.input.end));
  }

  StepResult<Out> finish_advance() override {
    StepResult<Out> result;
    Reply& reply = link_.finish(result.cost);
    result.outcome = reply.outcome;
    result.message = std::move(reply.message);
    result.output = outputs(reply);
    result.jacobian = std::move(reply.jacobian);
    result.solver_iterations = reply.solver_iterations;
    result.output_error_N = reply.output_error_N;
    return result;
  }

  CommandResult command(const std::string& text) override {
    Request head = make(RequestKind::Command);
    head.command = text;
    CommandResult result;
    Reply& reply = link_.call(view(head, {}, {}), result.cost);
    result.accepted = reply.outcome == Outcome::Done;
    result.message = std::move(reply.message);
    return result;
  }

  void checkpoint() override {
    checkpoint_first_ = true;
    link_.accept_input();
    ++macro_step_;
    iteration_ = 0;
  }

  // Right after a checkpoint the state is the saved one already.
  void rollback() override { rollback_first_ = rollback_first_ || !checkpoint_first_; }

  Observation observe() override {
    Request head = make(RequestKind::Observe);
    CallCost cost;
    return link_.call(view(head, {}, {}), cost).observation;
  }

  void append_times(std::vector<PartTimes>& to) const override { to.push_back(link_.times()); }

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

  static const In& none() {
    static const In kNone;
    return kNone;
  }
  static RequestView view(Request& head, const In& begin, const In& end) {
    if constexpr (std::is_same_v<In, WrenchSet>) {
      return {.head = head, .wrenches_begin = begin, .wrenches_end = end};
    } else {
      return {.head = head, .motions_begin = begin, .motions_end = end};
    }
  }
  static Out outputs(Reply& reply) {
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
