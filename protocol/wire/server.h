#pragma once

#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>

#include "protocol/wire/request_server.h"
#include "protocol/wire/segment_memory.h"

namespace tandem::wire {

namespace detail {

/// A request that a side can be given: its input has an entry for each port, the other kind none.
/// The begin of a segment may be left out.
template <class In, class Other>
void require_ports(const SubsystemInfo& info, const Request& request, const Segment<In>& input,
                   const Segment<Other>& other) {
  const bool initializes = request.call == RequestKind::Initialize;
  if (!initializes && request.call != RequestKind::Advance) return;
  const std::size_t ports = info.ports.size();
  const bool begin_fits = input.begin.empty() || (!initializes && input.begin.size() == ports);
  if (begin_fits && input.end.size() == ports && other.begin.empty() && other.end.empty() &&
      (initializes || request.step > SimTime{})) {
    return;
  }
  throw Error(ErrorKind::Partner,
              info.name + ": request " + std::to_string(request.header.sequence) + " (macro step " +
                  std::to_string(request.header.macro_step) + ") of " +
                  std::to_string(request.step.count()) + " ns holds " +
                  std::to_string(input.begin.size()) + " inputs at its beginning and " +
                  std::to_string(input.end.size()) + " at its end; the run has " +
                  std::to_string(ports) + " ports. Is a second driver on this run?");
}

}  // namespace detail

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
                                          ": the request leaves out the beginning of its segment, "
                                          "and no input was accepted before. Is a second driver on "
                                          "this run?");
    }
    StepResult<Out> result = side.advance(step);
    if (known) memory.lend(step.input.begin);
    memory.given(step.input.end);
    std::swap(step.input, input);  // keeps its memory for the next request
    reply.outcome = result.outcome;
    reply.message = std::move(result.message);
    reply.jacobian = std::move(result.jacobian);
    reply.solver_iterations = result.solver_iterations;
    reply.output_error_N = result.output_error_N;
    return std::move(result.output);
  };
  const auto execute = [&](Request& request, Reply& reply) {
    if constexpr (kIsMbs) {
      detail::require_ports(side.info(), request, request.wrenches, request.motions);
    } else {
      detail::require_ports(side.info(), request, request.motions, request.wrenches);
    }
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
