#pragma once

#include <type_traits>
#include <utility>

#include "protocol/wire/request_server.h"
#include "protocol/wire/segment_memory.h"

namespace tandem::wire {

/// Serves `side` to the driver until the driver says bye; see RequestServer::run(). Construct the
/// bus, a Heartbeat and a LivenessMonitor on the driver (and the orchestrator) first.
template <class In, class Out>
void serve(Subsystem<In, Out>& side, Bus& bus, LivenessMonitor& monitor,
           const ServerOptions& options) {
  constexpr bool kIsMbs = std::is_same_v<In, WrenchSet>;
  SegmentMemory<In> memory;
  StepRequest<In> step;
  const auto advance = [&](Segment<In>& input, const Request& request, Reply& reply) {
    step.step = request.step;
    step.linearize = request.linearize;
    std::swap(step.input, input);
    const bool known = step.input.begin.empty();
    if (known) memory.lend(step.input.begin);
    if (step.input.begin.size() != step.input.end.size()) {
      throw Error(ErrorKind::Partner, side.info().name +
                                          ": the request has another number of ports at its "
                                          "beginning than at its end");
    }
    StepResult<Out> result = side.advance(step);
    if (known) memory.lend(step.input.begin);
    memory.given(step.input.end);
    std::swap(step.input, input);  // keeps its memory for the next request
    reply.outcome = result.outcome;
    reply.message = std::move(result.message);
    reply.jacobian = std::move(result.jacobian);
    reply.solver_iterations = result.solver_iterations;
    return std::move(result.output);
  };
  const auto execute = [&](Request& request, Reply& reply) {
    if (request.rollback_first) side.rollback();
    if (request.checkpoint_first) {
      side.checkpoint();
      memory.accept();
    }
    auto& input = [&]() -> Segment<In>& {
      if constexpr (kIsMbs) {
        return request.wrenches;
      } else {
        return request.motions;
      }
    }();
    auto& output = [&]() -> Out& {
      if constexpr (kIsMbs) {
        return reply.motions;
      } else {
        return reply.wrenches;
      }
    }();
    switch (request.call) {
      case RequestKind::Initialize:
        output = side.initialize(input.end);
        memory.given(input.end);
        break;
      case RequestKind::Advance:
        output = advance(input, request, reply);
        break;
      case RequestKind::Observe:
        reply.observation = side.observe();
        break;
      case RequestKind::Command: {
        const CommandResult result = side.command(request.command);
        reply.outcome = result.accepted ? Outcome::Done : Outcome::Failed;
        reply.message = result.message;
        break;
      }
      case RequestKind::Bye:
        break;
    }
  };
  RequestServer server(bus, monitor, options, side.info(), execute);
  server.run();
}

}  // namespace tandem::wire
