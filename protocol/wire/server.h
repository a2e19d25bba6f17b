#pragma once

#include <utility>

#include "protocol/wire/request_server.h"

namespace tandem::wire {

/// Serves `side` to the driver until the driver says bye; see RequestServer::run(). Construct the
/// bus, a Heartbeat and a LivenessMonitor on the driver (and the orchestrator) first.
template <class In, class Out>
void serve(Subsystem<In, Out>& side, Bus& bus, LivenessMonitor& monitor,
           const ServerOptions& options) {
  constexpr bool kIsMbs = std::is_same_v<In, WrenchSet>;
  const auto advance = [&](const Request& request, Reply& reply) {
    StepRequest<In> step{.step = request.step, .input = {}, .linearize = request.linearize};
    if constexpr (kIsMbs) {
      step.input = request.wrenches;
    } else {
      step.input = request.motions;
    }
    StepResult<Out> result = side.advance(step);
    reply.outcome = result.outcome;
    reply.message = std::move(result.message);
    reply.jacobian = std::move(result.jacobian);
    reply.solver_iterations = result.solver_iterations;
    if constexpr (kIsMbs) {
      reply.motions = std::move(result.output);
    } else {
      reply.wrenches = std::move(result.output);
    }
  };
  const auto execute = [&](const Request& request, Reply& reply) {
    if (request.rollback_first) side.rollback();
    if (request.checkpoint_first) side.checkpoint();
    switch (request.call) {
      case RequestKind::Initialize:
        if constexpr (kIsMbs) {
          reply.motions = side.initialize(request.wrenches.end);
        } else {
          reply.wrenches = side.initialize(request.motions.end);
        }
        break;
      case RequestKind::Advance:
        advance(request, reply);
        break;
      case RequestKind::Observe:
        reply.observation = side.observe();
        break;
      case RequestKind::Bye:
        break;
    }
  };
  RequestServer server(bus, monitor, options, side.info(), execute);
  server.run();
}

}  // namespace tandem::wire
