#include "orchestrator/record/call_timeline.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/contract/error.h"

namespace tandem::orchestrator {

CallTimeline::CallTimeline(const std::vector<std::string>& bodies,
                           const std::vector<std::string>& worlds)
    : worlds_(worlds.size()) {
  for (const std::string& world : worlds) names_.push_back(world.empty() ? "mbs" : world);
  for (const std::string& body : bodies) names_.push_back(body.empty() ? "fem" : body);
  clocks_.resize(names_.size());
}

CallTimeline::Range CallTimeline::workers_of(wire::SideName side) const {
  if (side == wire::SideName::Mbs) return {0, worlds_};
  return {worlds_, names_.size()};
}

std::string CallTimeline::program_of(std::size_t worker) const {
  const bool rigid = worker < worlds_;
  const std::string program = rigid ? "tandem-mbs" : "tandem-fem";
  const std::string& name = names_[worker];
  const bool is_one = rigid && worlds_ == 1;
  return is_one || "tandem-" + name == program ? program : program + " " + name;
}

std::size_t CallTimeline::worker_of(const wire::CallRecord& call, std::size_t part) const {
  const Range range = workers_of(call.side);
  const bool one_of_several = call.kind == wire::CallKind::Command && range.size() > 1;
  if (one_of_several) {
    const auto begin = names_.begin() + static_cast<std::ptrdiff_t>(range.begin);
    const auto name =
        std::find(begin, names_.end(), call.command.substr(0, call.command.find(' ')));
    if (name != names_.end()) return static_cast<std::size_t>(name - names_.begin());
  }
  require(part < range.size() && (one_of_several || call.times.parts.size() <= 1 ||
                                  call.times.parts.size() == range.size()),
          fmt::format("log: a call of macro step {} has times of {} {}; the scenario has {}",
                      call.macro_step, call.times.parts.size(),
                      call.side == wire::SideName::Mbs ? "worlds" : "bodies", range.size()));
  return range.begin + part;
}

OffsetBounds CallTimeline::bounds_of(const wire::PartTimes& part, double origin_us) {
  const double end_s = 1e-6 * (part.side_us - origin_us);
  return {.at_s = 0.5 * (part.sent_s + part.arrived_s),
          .low_s = end_s + part.encode_s - part.arrived_s,
          .high_s = end_s - part.compute_s - part.decode_s - part.sent_s};
}

void CallTimeline::learn(const wire::StepJournal& journal) {
  for (const wire::CallRecord& call : journal.calls) {
    if (call.times.end_s == 0.0) {
      lacks_times_ = true;
      continue;
    }
    if (!origin_s_) origin_s_ = call.times.begin_s;
    for (std::size_t p = 0; p < call.times.parts.size(); ++p) {
      const wire::PartTimes& part = call.times.parts[p];
      if (part.side_us == 0.0) continue;
      Clock& clock = clocks_[worker_of(call, p)];
      if (clock.bounds.empty()) clock.origin_us = part.side_us;
      clock.bounds.push_back(bounds_of(part, clock.origin_us));
    }
  }
}

void CallTimeline::fit() {
  for (Clock& clock : clocks_) clock.fit = fit_clock(clock.bounds);
}

std::vector<Errand> CallTimeline::errands(const wire::CallRecord& call) const {
  const bool discarded = !call.accepted && call.kind == wire::CallKind::Advance;
  const auto here = [&](std::size_t part, double begin_s, double end_s) {
    return Errand{.worker = worker_of(call, part),
                  .here = true,
                  .discarded = discarded,
                  .sent_s = begin_s,
                  .awaited_s = begin_s,
                  .arrived_s = end_s,
                  .start_s = begin_s,
                  .end_s = end_s};
  };
  if (call.times.parts.empty()) return {here(0, call.times.begin_s, call.times.end_s)};
  std::vector<Errand> errands;
  for (std::size_t p = 0; p < call.times.parts.size(); ++p) {
    const wire::PartTimes& part = call.times.parts[p];
    if (part.side_us == 0.0) {
      errands.push_back(here(p, part.sent_s, part.arrived_s));
      continue;
    }
    const std::size_t worker = worker_of(call, p);
    const Clock& clock = clocks_[worker];
    const double end_s = 1e-6 * (part.side_us - clock.origin_us) -
                         clock.fit.offset(bounds_of(part, clock.origin_us));
    errands.push_back({.worker = worker,
                       .here = false,
                       .discarded = discarded,
                       .sent_s = part.sent_s,
                       .awaited_s = part.awaited_s,
                       .arrived_s = part.arrived_s,
                       .start_s = end_s - part.compute_s,
                       .end_s = end_s,
                       .decode_s = part.decode_s,
                       .encode_s = part.encode_s});
  }
  return errands;
}

StepTimes CallTimeline::step(const wire::StepJournal& journal,
                             const wire::StepJournal* next) const {
  StepTimes step;
  if (journal.calls.empty()) return step;
  step.whole = {journal.calls.front().times.begin_s, journal.calls.front().times.end_s};
  for (const wire::CallRecord& call : journal.calls) {
    step.calls.push_back({call.times.begin_s, call.times.end_s});
    step.whole.begin_s = std::min(step.whole.begin_s, call.times.begin_s);
    step.whole.end_s = std::max(step.whole.end_s, call.times.end_s);
    for (const Errand& errand : errands(call)) step.errands.push_back(errand);
  }
  // A thinned log does not say when the macro step ended.
  if (next == nullptr || next->calls.empty() ||
      next->step.macro_step != journal.step.macro_step + 1) {
    return step;
  }
  double next_s = next->calls.front().times.begin_s;
  for (const wire::CallRecord& call : next->calls) next_s = std::min(next_s, call.times.begin_s);
  step.whole.end_s = std::max(step.whole.end_s, next_s);
  // A record cannot hold the time of writing it: the one behind it does.
  step.recording_s = next->step.ledger.record_s;
  step.credit_s = next->step.ledger.wait_s;
  return step;
}

}  // namespace tandem::orchestrator
