#include "protocol/driver/composite_fem.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocol/contract/error.h"
#include "protocol/contract/hash.h"

namespace tandem {
namespace {

constexpr Eigen::Index kMotion = 12, kWrench = 6;  ///< rows of a port in a Jacobian's two sides

std::string named(const FemPart& part, const std::string& message) {
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
template <class Call>
auto timed(const FemPart& part, std::vector<wire::PartTimes>& times, const Call& call) {
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

SubsystemInfo joined_info(const std::vector<FemPart>& parts) {
  SubsystemInfo info{.name = "fem", .ports = {}, .micro_step = {}, .can_linearize = true};
  std::size_t ports = 0;
  for (const FemPart& part : parts) ports += part.ports.size();
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

CompositeFem::CompositeFem(std::vector<FemPart> parts)
    : parts_(std::move(parts)), info_(joined_info(parts_)) {}

WrenchSet CompositeFem::initialize(const MotionSet& motions) {
  WrenchSet wrenches(info_.ports.size());
  times_.clear();
  for_each(parts_, [&](FemPart& part) {
    const WrenchSet own =
        timed(part, times_, [&] { return part.side->initialize(of_ports(motions, part.ports)); });
    for (std::size_t i = 0; i < own.size(); ++i) wrenches[part.ports[i]] = own[i];
  });
  return wrenches;
}

StepResult<WrenchSet> CompositeFem::advance(const StepRequest<MotionSet>& request) {
  begin_advance(request);
  return finish_advance();
}

void CompositeFem::begin_advance(const StepRequest<MotionSet>& request) {
  linearizes_ = request.linearize;
  for_each(parts_, [&](FemPart& part) {
    part.side->begin_advance({.step = request.step,
                              .input = {of_ports(request.input.begin, part.ports),
                                        of_ports(request.input.end, part.ports)},
                              .linearize = request.linearize});
  });
}

StepResult<WrenchSet> CompositeFem::finish_advance() {
  StepResult<WrenchSet> all;
  times_.clear();
  all.outcome = Outcome::Done;
  all.message.clear();
  all.output.resize(info_.ports.size());
  if (linearizes_) {
    const auto ports = static_cast<Eigen::Index>(info_.ports.size());
    all.jacobian = InterfaceJacobian::Zero(kWrench * ports, kMotion * ports);
  }
  for_each(parts_, [&](FemPart& part) {
    StepResult<WrenchSet> own = timed(part, times_, [&] { return part.side->finish_advance(); });
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

void CompositeFem::gather(const FemPart& part, StepResult<WrenchSet>& from,
                          StepResult<WrenchSet>& all) const {
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
      all.jacobian->block<kWrench, kMotion>(kWrench * static_cast<Eigen::Index>(part.ports[r]),
                                            kMotion * static_cast<Eigen::Index>(part.ports[c])) =
          from.jacobian->block<kWrench, kMotion>(kWrench * static_cast<Eigen::Index>(r),
                                                 kMotion * static_cast<Eigen::Index>(c));
    }
  }
}

void CompositeFem::checkpoint() {
  for_each(parts_, [](FemPart& part) { part.side->checkpoint(); });
}

void CompositeFem::rollback() {
  for_each(parts_, [](FemPart& part) { part.side->rollback(); });
}

CommandResult CompositeFem::command(const std::string& text) {
  const std::size_t space = text.find(' ');
  const std::string name = text.substr(0, space);
  std::vector<std::string> names;
  for (FemPart& part : parts_) {
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

Observation CompositeFem::observe() {
  Observation all;
  StateHash hash;
  for_each(parts_, [&](FemPart& part) {
    const Observation own = part.side->observe();
    all.time = own.time;
    all.energy += own.energy;
    hash.add(own.state_hash);
    all.elastic_turn_rad = std::max(all.elastic_turn_rad, own.elastic_turn_rad);
    all.bodies.push_back({.name = part.name,
                          .energy = own.energy,
                          .state_hash = own.state_hash,
                          .compute_s = part.compute_s,
                          .solver_iterations = part.solver_iterations});
  });
  all.state_hash = hash.value();
  return all;
}

void CompositeFem::append_times(std::vector<wire::PartTimes>& to) const {
  to.insert(to.end(), times_.begin(), times_.end());
}

std::unique_ptr<FemSide> composed(std::vector<FemPart> parts) {
  if (parts.size() == 1) return std::move(parts.front().side);
  return std::make_unique<CompositeFem>(std::move(parts));
}

}  // namespace tandem
