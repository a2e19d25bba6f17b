#include "protocol/scenario/event_times.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "protocol/scenario/data.h"

namespace tandem::scenario {
namespace {

/// Times of one mapping itself, not of those within it.
void add_own_times(const Data& data, std::vector<double>& times_s) {
  const auto real_of = [&](std::string_view key) {
    const auto found = data.values.find(key);
    if (found == data.values.end()) return;
    if (const auto* time_s = std::get_if<double>(&found->second.content)) {
      times_s.push_back(*time_s);
    }
  };
  real_of("at_s");
  if (!data.values.contains("kind")) return;
  real_of("begin_s");
  real_of("end_s");
  const auto table = data.values.find("times_s");
  if (table == data.values.end()) return;
  if (const auto* points = std::get_if<std::vector<double>>(&table->second.content)) {
    times_s.insert(times_s.end(), points->begin(), points->end());
  }
}

void add_times(const Data& data, std::vector<double>& times_s) {
  add_own_times(data, times_s);
  for (const auto& [key, value] : data.values) {
    if (const auto* section = std::get_if<DataPtr>(&value.content)) {
      add_times(**section, times_s);
    } else if (const auto* sections = std::get_if<std::vector<DataPtr>>(&value.content)) {
      for (const DataPtr& one : *sections) add_times(*one, times_s);
    }
  }
}

}  // namespace

std::vector<SimTime> event_times(const Node& root, SimTime end) {
  std::vector<double> times_s;
  add_times(root.data(), times_s);
  std::vector<SimTime> events;
  for (const double time_s : times_s) {
    // 1e-3 ns: 0.3 s is not a whole number of nanoseconds as a double.
    const double time_ns = std::floor(1e9 * time_s + 1e-3);
    if (time_ns > 0.0 && time_ns < static_cast<double>(end.count())) {
      events.emplace_back(static_cast<std::int64_t>(time_ns));
    }
  }
  std::sort(events.begin(), events.end());
  events.erase(std::unique(events.begin(), events.end()), events.end());
  return events;
}

}  // namespace tandem::scenario
