#include "protocol/driver/composite_side.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "protocol/contract/error.h"
#include "protocol/contract/hash.h"

namespace tandem {
namespace {

/// Whether the side maps motions to wrenches.
template <class In>
constexpr bool kFlexible = std::is_same_v<In, MotionSet>;

/// Entries of a port in a set, as a Jacobian's rows or columns hold them.
template <class Set>
constexpr Eigen::Index kWidth = std::is_same_v<Set, MotionSet> ? 12 : 6;

template <class Part>
std::string named(const Part& part, const std::string& message) {
  return message.empty() ? message : part.name + ": " + message;
}

/// Calls `call` for each part; an error carries the part's name.
template <class Parts, class Call>
void for_each(Parts& parts, const Call& call) {
  for (auto& part : parts) {
    try {
      call(part);
    } catch (const Error& error) {
      throw Error(error.kind(), named(part, error.what()));
    }
  }
}

/// What `call`, the end of a call to the part, gives; its times are booked.
template <class Part, class Call>
auto timed(const Part& part, std::vector<wire::PartTimes>& times, const Call& call) {
  const double begin_s = now_s();
  auto result = call();
  if (const auto* own = dynamic_cast<const wire::TimedCalls*>(part.side.get())) {
    own->append_times(times);
  } else {
    const double end_s = now_s();
    times.push_back({.sent_s = begin_s,
                     .awaited_s = begin_s,
                     .arrived_s = end_s,
                     .side_us = 0.0,
                     .compute_s = end_s - begin_s});
  }
  return result;
}

template <class In, class Out>
SubsystemInfo joined_info(const std::vector<SidePart<In, Out>>& parts) {
  SubsystemInfo info{
      .name = kFlexible<In> ? "fem" : "mbs", .ports = {}, .micro_step = {}, .can_linearize = true};
  std::size_t ports = 0;
  for (const auto& part : parts) ports += part.ports.size();
  info.ports.resize(ports);
  for (std::size_t b = 0; b < parts.size(); ++b) {
    const SubsystemInfo& own = parts[b].side->info();
    for (std::size_t i = 0; i < parts[b].ports.size(); ++i) {
      PortInfo& port = info.ports.at(parts[b].ports[i]);
      port = own.ports.at(i);
      port.body = static_cast<std::int32_t>(b);
    }
    info.can_linearize = info.can_linearize && own.can_linearize;
    if (own.micro_step == SimTime{}) continue;
    info.micro_step =
        info.micro_step == SimTime{} ? own.micro_step : std::min(info.micro_step, own.micro_step);
  }
  return info;
}

}  // namespace

template <class In, class Out>
CompositeSide<In, Out>::CompositeSide(std::vector<Part> parts)
    : parts_(std::move(parts)), info_(joined_info(parts_)) {}

template <class In, class Out>
Out CompositeSide<In, Out>::initialize(const In& input) {
  Out output(info_.ports.size());
  times_.clear();
  for_each(parts_, [&](Part& part) {
    const Out own =
        timed(part, times_, [&] { return part.side->initialize(of_ports(input, part.ports)); });
    for (std::size_t i = 0; i < own.size(); ++i) output[part.ports[i]] = own[i];
  });
  return output;
}

template <class In, class Out>
StepResult<Out> CompositeSide<In, Out>::advance(const StepRequest<In>& request) {
  begin_advance(request);
  return finish_advance();
}

template <class In, class Out>
void CompositeSide<In, Out>::begin_advance(const StepRequest<In>& request) {
  linearizes_ = request.linearize;
  for_each(parts_, [&](Part& part) {
    part.side->begin_advance({.step = request.step,
                              .input = {of_ports(request.input.begin, part.ports),
                                        of_ports(request.input.end, part.ports)},
                              .linearize = request.linearize});
  });
}

template <class In, class Out>
StepResult<Out> CompositeSide<In, Out>::finish_advance() {
  StepResult<Out> all;
  times_.clear();
  all.outcome = Outcome::Done;
  all.message.clear();
  all.output.resize(info_.ports.size());
  if (linearizes_) {
    const auto ports = static_cast<Eigen::Index>(info_.ports.size());
    all.jacobian = InterfaceJacobian::Zero(kWidth<Out> * ports, kWidth<In> * ports);
  }
  for_each(parts_, [&](Part& part) {
    StepResult<Out> own = timed(part, times_, [&] { return part.side->finish_advance(); });
    // A part of this process does not book its own time.
    if (times_.back().side_us == 0.0) own.cost.compute_s = times_.back().compute_s;
    part.compute_s += times_.back().compute_s;
    part.solver_iterations += own.solver_iterations;
    gather(part, own, all);
  });
  all.output_error_N = std::sqrt(all.output_error_N);
  if (all.outcome == Outcome::Failed) {
    all.output.clear();
    all.jacobian.reset();
    rollback();
  }
  return all;
}

template <class In, class Out>
void CompositeSide<In, Out>::gather(const Part& part, StepResult<Out>& from,
                                    StepResult<Out>& all) const {
  constexpr Eigen::Index kRows = kWidth<Out>, kColumns = kWidth<In>;
  all.outcome = std::max(all.outcome, from.outcome);
  if (!from.message.empty()) {
    all.message += (all.message.empty() ? "" : "; ") + named(part, from.message);
  }
  all.output_error_N += from.output_error_N * from.output_error_N;
  all.solver_iterations += from.solver_iterations;
  all.cost += from.cost;
  for (std::size_t i = 0; i < from.output.size(); ++i) {
    all.output[part.ports[i]] = from.output[i];
  }
  if (!from.jacobian) {
    all.jacobian.reset();
    return;
  }
  if (!all.jacobian) return;
  for (std::size_t r = 0; r < part.ports.size(); ++r) {
    for (std::size_t c = 0; c < part.ports.size(); ++c) {
      all.jacobian->template block<kRows, kColumns>(
          kRows * static_cast<Eigen::Index>(part.ports[r]),
          kColumns * static_cast<Eigen::Index>(part.ports[c])) =
          from.jacobian->template block<kRows, kColumns>(kRows * static_cast<Eigen::Index>(r),
                                                         kColumns * static_cast<Eigen::Index>(c));
    }
  }
}

template <class In, class Out>
void CompositeSide<In, Out>::checkpoint() {
  for_each(parts_, [](Part& part) { part.side->checkpoint(); });
}

template <class In, class Out>
void CompositeSide<In, Out>::rollback() {
  for_each(parts_, [](Part& part) { part.side->rollback(); });
}

template <class In, class Out>
CommandResult CompositeSide<In, Out>::command(const std::string& text) {
  if constexpr (!kFlexible<In>) return Subsystem<In, Out>::command(text);
  const std::size_t space = text.find(' ');
  const std::string name = text.substr(0, space);
  std::vector<std::string> names;
  for (Part& part : parts_) {
    if (part.name != name || space == std::string::npos) {
      names.push_back(part.name);
      continue;
    }
    times_.clear();
    CommandResult result =
        timed(part, times_, [&] { return part.side->command(text.substr(space + 1)); });
    result.message = named(part, result.message);
    return result;
  }
  return {
      .accepted = false,
      .message = fmt::format("fem: '{}': which flexible body is meant? Name it with --body: {}.",
                             text, fmt::join(names, ", ")),
      .cost = {}};
}

template <class In, class Out>
Observation CompositeSide<In, Out>::observe() {
  Observation all;
  StateHash hash;
  for_each(parts_, [&](Part& part) {
    const Observation own = part.side->observe();
    all.time = own.time;
    all.energy += own.energy;
    hash.add(own.state_hash);
    all.elastic_turn_rad = std::max(all.elastic_turn_rad, own.elastic_turn_rad);
    // Written so that a gap that is no number is kept.
    if (own.widest_joint.joint >= 0 && !(own.widest_joint.part <= all.widest_joint.part)) {
      all.widest_joint = own.widest_joint;
      all.widest_joint.world = static_cast<std::int32_t>(all.bodies.size());
    }
    all.bodies.push_back({.name = part.name,
                          .energy = own.energy,
                          .state_hash = own.state_hash,
                          .compute_s = part.compute_s,
                          .solver_iterations = part.solver_iterations});
  });
  all.state_hash = hash.value();
  return all;
}

template <class In, class Out>
void CompositeSide<In, Out>::append_times(std::vector<wire::PartTimes>& to) const {
  to.insert(to.end(), times_.begin(), times_.end());
}

template class CompositeSide<MotionSet, WrenchSet>;
template class CompositeSide<WrenchSet, MotionSet>;

}  // namespace tandem
