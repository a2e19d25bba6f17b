#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "orchestrator/files/text_file.h"
#include "orchestrator/record/call_timeline.h"
#include "orchestrator/record/critical_path.h"

namespace tandem::orchestrator {

/// A file in the Chrome trace-event format (JSON object format; ui.perfetto.dev, speedscope,
/// chrome://tracing), written event by event. Times in µs since the run's first call. One process a
/// process of the run; in the driver's one track of its own doing, one of macro steps, and one of
/// the critical path; counters of residual, iterations and bytes; a flow (arrow) for each request
/// and each reply.
class TraceEvents {
 public:
  /// `driver`: its process's name.
  TraceEvents(const std::filesystem::path& file, const CallTimeline& timeline, std::string driver);

  void add_calls(const wire::StepJournal& journal);
  void add_step(const wire::StepRecord& record, const StepTimes& step,
                const std::vector<PathPiece>& path, const std::vector<std::string>& places);

  /// Ends the file; `about` is kept as otherData.
  void finish(const nlohmann::ordered_json& about);

  [[nodiscard]] std::int64_t events() const { return events_; }

 private:
  using Json = nlohmann::ordered_json;
  struct Track {
    std::int64_t process = 1;
    std::int64_t thread = 1;
  };

  [[nodiscard]] double us(double at_s) const;
  [[nodiscard]] Track track_of(std::size_t worker) const;
  void add(const Json& event);
  void name(const Track& track, const std::string& process, const std::string& thread);
  void slice(const Track& track, const std::string& name, const Interval& time, const Json& args,
             bool discarded = false);
  void counter(double at_s, const std::string& name, const std::string& unit, double value);
  /// From one track to another; ends at its begin where the clocks' resolution would turn it round.
  void arrow(const std::string& name, const Track& from, double from_s, const Track& to,
             double to_s);
  void add_errand(const Errand& errand, const std::string& what, const Json& args);

  TextFile file_;
  const CallTimeline& timeline_;
  std::int64_t events_ = 0;
  std::int64_t arrows_ = 0;
};

}  // namespace tandem::orchestrator
