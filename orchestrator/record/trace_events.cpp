#include "orchestrator/record/trace_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "orchestrator/record/path_book.h"

namespace tandem::orchestrator {
namespace {

constexpr std::int64_t kDriver = 1;                      // number of its process
constexpr std::int64_t kOwn = 1, kSteps = 2, kPath = 3;  // its tracks

// Viewers bind an arrow to the slice that is open at its time: one resolution before its end.
constexpr double kResolution_s = 1e-9;

const char* event_name(wire::CallKind kind) {
  switch (kind) {
    case wire::CallKind::Initialize:
      return "initialize";
    case wire::CallKind::Advance:
      return "advance";
    case wire::CallKind::Command:
      return "command";
  }
  return "unknown";
}

const char* outcome_name(Outcome outcome) {
  switch (outcome) {
    case Outcome::Done:
      return "done";
    case Outcome::NotConverged:
      return "not converged";
    case Outcome::Failed:
      return "failed";
  }
  return "unknown";
}

}  // namespace

TraceEvents::TraceEvents(const std::filesystem::path& file, const CallTimeline& timeline,
                         std::string driver)
    : file_(file), timeline_(timeline) {
  file_.write("{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n");
  name({kDriver, kOwn}, driver, "driver");
  name({kDriver, kSteps}, {}, "macro steps");
  name({kDriver, kPath}, {}, "critical path");
  for (std::size_t w = 0; w < timeline_.workers().size(); ++w) {
    if (timeline_.is_here(w)) continue;
    name(track_of(w), timeline_.program_of(w), timeline_.workers()[w]);
  }
}

TraceEvents::Track TraceEvents::track_of(std::size_t worker) const {
  if (timeline_.is_here(worker)) return {kDriver, kOwn};
  return {kDriver + 1 + static_cast<std::int64_t>(worker), kOwn};
}

double TraceEvents::us(double at_s) const {
  return std::round(1e9 * (at_s - timeline_.origin_s())) / 1e3;
}

void TraceEvents::add(const Json& event) {
  file_.write((events_++ == 0 ? "" : ",\n") + event.dump());
}

void TraceEvents::name(const Track& track, const std::string& process, const std::string& thread) {
  if (!process.empty()) {
    add({{"ph", "M"},
         {"name", "process_name"},
         {"pid", track.process},
         {"args", {{"name", process}}}});
    add({{"ph", "M"},
         {"name", "process_sort_index"},
         {"pid", track.process},
         {"args", {{"sort_index", track.process}}}});
  }
  add({{"ph", "M"},
       {"name", "thread_name"},
       {"pid", track.process},
       {"tid", track.thread},
       {"args", {{"name", thread}}}});
}

void TraceEvents::slice(const Track& track, const std::string& name, const Interval& time,
                        const Json& args, bool discarded) {
  const double begin_us = us(time.begin_s);
  Json event{{"ph", "X"},
             {"name", discarded ? name + " (rolled back)" : name},
             {"cat", discarded ? "rolled back" : "accepted"},
             {"pid", track.process},
             {"tid", track.thread},
             {"ts", begin_us},
             {"dur", std::max(0.0, std::round(1e3 * (us(time.end_s) - begin_us)) / 1e3)}};
  if (discarded) event["cname"] = "grey";
  if (!args.empty()) event["args"] = args;
  add(event);
}

void TraceEvents::counter(double at_s, const std::string& name, const std::string& unit,
                          double value) {
  // JSON has no number for a residual that is none.
  if (!std::isfinite(value)) return;
  add({{"ph", "C"}, {"name", name}, {"pid", kDriver}, {"ts", us(at_s)}, {"args", {{unit, value}}}});
}

void TraceEvents::arrow(const std::string& name, const Track& from, double from_s, const Track& to,
                        double to_s) {
  ++arrows_;
  const auto end = [&](const char* phase, const Track& track, double at_us) {
    return Json{{"ph", phase},          {"name", name},        {"cat", "exchange"}, {"id", arrows_},
                {"pid", track.process}, {"tid", track.thread}, {"ts", at_us}};
  };
  const double from_us = us(from_s);
  add(end("s", from, from_us));
  Json arrival = end("f", to, std::max(from_us, us(to_s)));
  arrival["bp"] = "e";
  add(arrival);
}

void TraceEvents::add_errand(const Errand& errand, const std::string& what, const Json& args) {
  const std::string& side = timeline_.workers()[errand.worker];
  const Track driver{kDriver, kOwn};
  const Track track = track_of(errand.worker);
  if (errand.here) {
    slice(driver, side + " " + what, {errand.start_s, errand.end_s}, args, errand.discarded);
    return;
  }
  const Interval busy{errand.start_s - errand.decode_s, errand.end_s + errand.encode_s};
  Json own = args;
  own["compute_us"] = std::round(1e9 * (errand.end_s - errand.start_s)) / 1e3;
  slice(track, what, busy, own, errand.discarded);
  if (errand.arrived_s > errand.awaited_s) {
    slice(driver, "wait for " + side, {errand.awaited_s, errand.arrived_s}, {}, errand.discarded);
  }
  arrow("request", driver, errand.sent_s - kResolution_s, track, busy.begin_s);
  arrow("reply", track, busy.end_s - kResolution_s, driver, errand.arrived_s - kResolution_s);
}

void TraceEvents::add_calls(const wire::StepJournal& journal) {
  for (const wire::CallRecord& call : journal.calls) {
    Json args{{"macro_step", call.macro_step}, {"iteration", call.iteration}};
    if (call.solver_iterations > 0) args["solver_iterations"] = call.solver_iterations;
    if (call.outcome != Outcome::Done) args["outcome"] = outcome_name(call.outcome);
    if (!call.message.empty()) args["message"] = call.message;
    if (!call.command.empty()) args["command"] = call.command;
    double asked_s = call.times.begin_s;
    double arrived_s = 0.0;
    for (const Errand& errand : timeline_.errands(call)) {
      if (!errand.here) {
        const std::string& side = timeline_.workers()[errand.worker];
        slice({kDriver, kOwn}, "ask " + side, {asked_s, errand.sent_s}, {}, errand.discarded);
        asked_s = errand.sent_s;
        arrived_s = std::max({arrived_s, errand.arrived_s, errand.awaited_s});
      }
      add_errand(errand, event_name(call.kind), args);
    }
    if (arrived_s > 0.0) {
      slice({kDriver, kOwn}, "take reply", {arrived_s, call.times.end_s}, {}, !call.accepted);
    }
  }
}

void TraceEvents::add_step(const wire::StepRecord& record, const StepTimes& step,
                           const std::vector<PathPiece>& path,
                           const std::vector<std::string>& places) {
  const std::size_t workers = timeline_.workers().size();
  Json args{{"t_s", to_seconds(record.time)},
            {"H_s", to_seconds(record.step)},
            {"iterations", record.iterations},
            {"critical_path", largest_shares(shares_of(path, workers), places)}};
  if (record.outcome != Outcome::Done) args["outcome"] = outcome_name(record.outcome);
  slice({kDriver, kSteps}, fmt::format("macro step {}", record.macro_step), step.whole, args);
  for (const PathPiece& piece : path) {
    slice({kDriver, kPath}, places[piece.place], piece.time, {}, piece.discarded);
  }
  counter(step.whole.begin_s, "residual", "N", record.residual_N);
  counter(step.whole.begin_s, "iterations", "iterations", record.iterations);
  counter(step.whole.begin_s, "bytes", "bytes", static_cast<double>(record.ledger.bytes));
}

void TraceEvents::finish(const nlohmann::ordered_json& about) {
  file_.write("\n],\"otherData\":" + about.dump() + "}\n");
  file_.flush();
}

}  // namespace tandem::orchestrator
