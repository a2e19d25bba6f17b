#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "protocol/contract/cost.h"
#include "protocol/wire/journal.h"

namespace tandem::wire {

/// The calls of both sides since the last take(), in the order they were made.
class CallJournal {
 public:
  CallRecord& append() { return calls_.emplace_back(); }

  /// Hands out the calls of the macro step that just ended. The last advance of each side is the
  /// accepted one; all others were rolled back.
  std::vector<CallRecord> take() {
    bool open[2] = {true, true};
    for (auto call = calls_.rbegin(); call != calls_.rend(); ++call) {
      if (call->kind == CallKind::Command) {
        call->accepted = call->outcome == Outcome::Done;
        continue;
      }
      bool& last = open[static_cast<int>(call->side)];
      call->accepted = last && call->outcome != Outcome::Failed;
      last = false;
    }
    return std::exchange(calls_, {});
  }

 private:
  std::vector<CallRecord> calls_;
};

/// Writes down every call that passes through to `inner`. Macro steps are counted by checkpoint():
/// the one before the first advance opens macro step 1. observe() changes nothing and is not
/// written down.
template <class In, class Out>
class JournaledSide final : public Subsystem<In, Out> {
 public:
  /// `timed` tells the times of the calls that `inner` makes; null = it computes in this process.
  JournaledSide(Subsystem<In, Out>& inner, CallJournal& journal, const TimedCalls* timed = nullptr)
      : inner_(inner), journal_(journal), timed_(timed) {}

  [[nodiscard]] const SubsystemInfo& info() const override { return inner_.info(); }

  Out initialize(const In& input) override {
    const double begin_s = now_s();
    Out output = inner_.initialize(input);
    CallRecord& call = append(CallKind::Initialize, begin_s);
    inputs(call).end = input;
    outputs(call).end = output;
    return output;
  }

  StepResult<Out> advance(const StepRequest<In>& request) override {
    const double begin_s = now_s();
    StepResult<Out> result = inner_.advance(request);
    write_down(request, result, begin_s);
    return result;
  }

  void begin_advance(const StepRequest<In>& request) override {
    begun_s_ = now_s();
    begun_ = request;
    inner_.begin_advance(request);
  }

  StepResult<Out> finish_advance() override {
    // A side of this process has not computed yet.
    const double begin_s = timed_ == nullptr ? now_s() : begun_s_;
    StepResult<Out> result = inner_.finish_advance();
    write_down(begun_, result, begin_s);
    return result;
  }

  CommandResult command(const std::string& text) override {
    const double begin_s = now_s();
    CommandResult result = inner_.command(text);
    CallRecord& call = append(CallKind::Command, begin_s);
    ++call.macro_step;  // it acts on the step that the next checkpoint opens
    call.iteration = 0;
    call.command = text;
    call.outcome = result.accepted ? Outcome::Done : Outcome::Failed;
    call.message = result.message;
    return result;
  }

  void checkpoint() override {
    inner_.checkpoint();
    checkpoint_first_ = true;
    ++macro_step_;
    iteration_ = 0;
  }

  void rollback() override {
    inner_.rollback();
    // Right after a checkpoint the state is the saved one already.
    rollback_first_ = rollback_first_ || !checkpoint_first_;
  }

  Observation observe() override { return inner_.observe(); }

 private:
  static constexpr bool kIsMbs = std::is_same_v<In, WrenchSet>;

  static Segment<In>& inputs(CallRecord& call) {
    if constexpr (kIsMbs) {
      return call.wrenches;
    } else {
      return call.motions;
    }
  }
  static Segment<Out>& outputs(CallRecord& call) {
    if constexpr (kIsMbs) {
      return call.motions;
    } else {
      return call.wrenches;
    }
  }

  void write_down(const StepRequest<In>& request, const StepResult<Out>& result, double begin_s) {
    ++iteration_;
    CallRecord& call = append(CallKind::Advance, begin_s);
    call.linearize = request.linearize;
    call.step = request.step;
    inputs(call) = request.input;
    outputs(call).end = result.output;
    call.outcome = result.outcome;
    call.message = result.message;
    call.solver_iterations = result.solver_iterations;
  }

  CallRecord& append(CallKind kind, double begin_s) {
    const double end_s = now_s();
    CallRecord& call = journal_.append();
    call.times.begin_s = begin_s;
    call.times.end_s = end_s;
    if (timed_ != nullptr) timed_->append_times(call.times.parts);
    call.side = kIsMbs ? SideName::Mbs : SideName::Fem;
    call.kind = kind;
    call.checkpoint_first = std::exchange(checkpoint_first_, false);
    call.rollback_first = std::exchange(rollback_first_, false);
    call.macro_step = macro_step_;
    call.iteration = iteration_;
    return call;
  }

  Subsystem<In, Out>& inner_;
  CallJournal& journal_;
  const TimedCalls* timed_;
  StepRequest<In> begun_;
  double begun_s_ = 0.0;
  bool checkpoint_first_ = false;
  bool rollback_first_ = false;
  std::int64_t macro_step_ = 0;
  std::int32_t iteration_ = 0;
};

using JournaledMbs = JournaledSide<WrenchSet, MotionSet>;
using JournaledFem = JournaledSide<MotionSet, WrenchSet>;

}  // namespace tandem::wire
