#include "orchestrator/record/trace.h"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "orchestrator/record/call_timeline.h"
#include "orchestrator/record/critical_path.h"
#include "orchestrator/record/path_book.h"
#include "orchestrator/record/trace_events.h"
#include "orchestrator/scenario/model.h"
#include "protocol/contract/error.h"
#include "protocol/wire/event_log.h"

namespace tandem::orchestrator {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> names_of(const std::vector<scenario::BodyPorts>& parts) {
  std::vector<std::string> names;
  for (const scenario::BodyPorts& part : parts) names.push_back(part.name);
  return names;
}

CallTimeline learned(const RunDirectory& run) {
  const Model model = load_model(run.scenario(), {});
  CallTimeline timeline(names_of(model.table), names_of(model.world_table));
  wire::LogReader log(run.log());
  std::int64_t steps = -1;
  for (; auto journal = log.next_step(); ++steps) timeline.learn(*journal);
  require(!timeline.lacks_times(),
          fmt::format("trace: {} holds no times of its calls: an older version of Tandem wrote it. "
                      "Run its scenario.yaml again.",
                      run.log().string()));
  require(steps > 0, fmt::format("trace: {} holds no macro step (output.log_every_steps: 0, or the "
                                 "run never began)",
                                 run.log().string()));
  timeline.fit();
  return timeline;
}

/// Name of the process that ran the loop: with a side in it, or with both, or in between.
std::string driver_of(const CallTimeline& timeline) {
  for (std::size_t w = 1; w < timeline.workers().size(); ++w) {
    if (!timeline.is_here(w)) return timeline.is_here(0) ? timeline.program_of(0) : "tandem";
  }
  return "tandem";
}

std::string clocks_text(const CallTimeline& timeline) {
  std::string text;
  for (std::size_t w = 0; w < timeline.workers().size(); ++w) {
    if (timeline.is_here(w)) continue;
    const ClockFit& clock = timeline.clock(w);
    text += fmt::format(
        "  {:<16} drift {:+.3f} ppm; placed to ±{:.1f} µs (median), ±{:.1f} µs "
        "(largest){}\n",
        timeline.workers()[w], 1e6 * clock.drift, 1e6 * clock.median_error_s,
        1e6 * clock.largest_error_s,
        clock.outside == 0 ? "" : fmt::format("; {} exchanges meet no line", clock.outside));
  }
  return text.empty() ? "clocks: one process, one clock\n" : "clocks against the driver's\n" + text;
}

Json about(const PathBook& book, const CallTimeline& timeline, const RunDirectory& run,
           const StepWindow& written) {
  Json shares, faster, clocks;
  for (std::size_t p = 0; p < book.places().size(); ++p) {
    shares[book.places()[p]] = book.shares()[p];
  }
  for (const PathBook::Prediction& prediction : book.predictions()) {
    faster[book.places()[prediction.worker]] = {{"twice_as_fast", prediction.twice_as_fast},
                                                {"in_no_time", prediction.in_no_time}};
  }
  for (std::size_t w = 0; w < timeline.workers().size(); ++w) {
    if (timeline.is_here(w)) continue;
    const ClockFit& clock = timeline.clock(w);
    clocks[timeline.workers()[w]] = {{"drift", clock.drift},
                                     {"median_error_s", clock.median_error_s},
                                     {"largest_error_s", clock.largest_error_s},
                                     {"outside", clock.outside}};
  }
  return {{"run", run.path().string()},
          {"macro_steps", book.steps()},
          {"traced", {written.first, written.last}},
          {"step_s", book.total_s() / static_cast<double>(book.steps())},
          {"critical_path", shares},
          {"rolled_back", book.discarded_share()},
          {"run_time_if", faster},
          {"clocks", clocks}};
}

/// The macro steps of a log, one by one with the one behind it.
class StepPairs {
 public:
  explicit StepPairs(const RunDirectory& run) : log_(run.log()), next_(log_.next_step()) {}

  bool advance() {
    now_ = std::move(next_);
    next_ = now_ ? log_.next_step() : std::nullopt;
    return now_.has_value();
  }
  [[nodiscard]] const wire::StepJournal& now() const { return *now_; }
  [[nodiscard]] const wire::StepJournal* next() const { return next_ ? &*next_ : nullptr; }

 private:
  wire::LogReader log_;
  std::optional<wire::StepJournal> now_, next_;
};

}  // namespace

StepWindow window_of(const std::string& text) {
  StepWindow window{0, std::numeric_limits<std::int64_t>::max()};
  const std::size_t colon = text.find(':');
  const auto read = [](const std::string& part, std::int64_t& value) {
    if (part.empty()) return true;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && end == part.data() + part.size();
  };
  require(colon != std::string::npos && read(text.substr(0, colon), window.first) &&
              read(text.substr(colon + 1), window.last) && window.first >= 0 &&
              window.first <= window.last,
          fmt::format("--steps {}: give the first and the last macro step, as 200:300", text));
  return window;
}

std::string trace(const RunDirectory& run, const std::filesystem::path& file,
                  const StepWindow& window) {
  const CallTimeline timeline = learned(run);
  const std::size_t workers = timeline.workers().size();
  std::vector<bool> here;
  for (std::size_t w = 0; w < workers; ++w) here.push_back(timeline.is_here(w));
  PathBook book(timeline.workers(), here);
  TraceEvents events(file, timeline, driver_of(timeline));
  StepWindow written{-1, -1};
  std::int64_t left_out = 0;
  for (StepPairs log(run); log.advance();) {
    const wire::StepJournal& journal = log.now();
    const std::int64_t number = journal.step.macro_step;
    const bool traced = number >= window.first && number <= window.last;
    if (traced) {
      if (written.first < 0) written.first = number;
      written.last = number;
      events.add_calls(journal);
    }
    // The initialization is no macro step.
    if (number == 0) continue;
    const StepTimes step = timeline.step(journal, log.next());
    const std::vector<PathPiece> path = critical_path(step, workers);
    book.add(number, step, path);
    if (traced) events.add_step(journal.step, step, path, book.places());
    left_out += traced ? 0 : 1;
  }
  events.finish(about(book, timeline, run, written));
  const std::string driver = driver_of(timeline) + " (driver)";
  return text_of(book, driver) + clocks_text(timeline) +
         fmt::format(
             "{}: {} events of macro steps {} to {}{}; open it in ui.perfetto.dev\n", file.string(),
             events.events(), written.first, written.last,
             left_out == 0 ? "" : fmt::format(", {} others left out (--steps a:b)", left_out));
}

}  // namespace tandem::orchestrator
