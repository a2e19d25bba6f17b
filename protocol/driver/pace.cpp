#include "protocol/driver/pace.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "protocol/contract/quantile.h"

namespace tandem {
namespace {

/// A sleeping process is woken some tens of µs late: the last of the wait is spent awake.
constexpr double kAwake_s = 1e-4;

/// Bounds of the histogram's bins, parts of the wall time of a macro step.
constexpr std::array<double, 9> kBounds = {-1.0, -0.5, -0.2, -0.1, 0.0, 0.1, 0.2, 0.5, 0.8};

/// Between two looks at what may end the run.
constexpr double kLongestRest_s = 0.02;

void wait_until(double due_s, const Pace::Rest& rest) {
  for (;;) {
    const double asleep_s = due_s - now_s() - kAwake_s;
    if (asleep_s <= 0.0) break;
    rest(std::min(asleep_s, kLongestRest_s));
  }
  while (now_s() < due_s) std::this_thread::yield();
}

std::string bin_name(std::size_t i) {
  const auto text = [](double bound) {
    std::string number = std::to_string(static_cast<int>(std::lround(100.0 * bound)));
    return number + " %";
  };
  if (i == 0) return "below " + text(kBounds.front());
  if (i == kBounds.size()) return "from " + text(kBounds.back());
  return text(kBounds[i - 1]) + " to " + text(kBounds[i]);
}

nlohmann::ordered_json quantiles(std::vector<double> values, bool late_is_low) {
  std::sort(values.begin(), values.end());
  if (late_is_low) {
    return {{"min", quantile(values, 0.0)},
            {"p0.1", quantile(values, 0.001)},
            {"p1", quantile(values, 0.01)},
            {"median", quantile(values, 0.5)}};
  }
  return {{"median", quantile(values, 0.5)},
          {"p99", quantile(values, 0.99)},
          {"p99.9", quantile(values, 0.999)},
          {"max", quantile(values, 1.0)}};
}

}  // namespace

nlohmann::ordered_json to_json(const PaceReport& report, SimTime macro_step) {
  const double step_us = 1e6 * to_seconds(macro_step) / report.factor;
  std::array<std::int64_t, kBounds.size() + 1> counts{};
  for (double slack_us : report.slack_us) {
    const auto bin = std::upper_bound(kBounds.begin(), kBounds.end(), slack_us / step_us);
    ++counts[static_cast<std::size_t>(bin - kBounds.begin())];
  }
  nlohmann::ordered_json json = {{"factor", report.factor},
                                 {"steps", report.slack_us.size()},
                                 {"misses", report.misses},
                                 {"waited_s", report.waited_s},
                                 {"slack_us", quantiles(report.slack_us, true)},
                                 {"step_us", quantiles(report.step_us, false)}};
  nlohmann::ordered_json& by = json["missed_by"] = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < PaceReport::kParts.size(); ++i) {
    by[PaceReport::kParts[i]] = report.missed_by[i];
  }
  nlohmann::ordered_json& bins = json["slack_of_step"] = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < counts.size(); ++i) bins[bin_name(i)] = counts[i];
  return json;
}

Pace::Pace(double factor) { report_.factor = factor; }

void Pace::begin() { begin_s_ = due_s_ = now_s(); }

void Pace::end_step(SimTime time, const Ledger& l, double step_s, const Rest& rest) {
  if (!report_.active()) return;
  const double due_s = begin_s_ + to_seconds(time) / report_.factor;
  const double end_s = now_s();
  Parts parts = {
      l.mbs_compute_s,       l.fem_compute_s, l.encode_s + l.decode_s + l.publish_s + l.transit_s,
      l.record_s + l.wait_s, l.scheme_s,      0.0};
  double named_s = 0.0;
  for (double part_s : parts) named_s += part_s;
  parts.back() = std::max(0.0, step_s - (named_s - l.overlap_s));
  if (end_s > due_s) {
    ++report_.misses;
    // Within its own time it is late for the step that was late before it.
    if (step_s > due_s - due_s_) slow_part_ = slowest(parts);
    ++report_.missed_by[slow_part_];
  }
  due_s_ = due_s;
  for (std::size_t i = 0; i < parts.size(); ++i) sums_s_[i] += parts[i];
  report_.slack_us.push_back(1e6 * (due_s - end_s));
  report_.step_us.push_back(1e6 * step_s);
  wait_until(due_s, rest);
  report_.waited_s += now_s() - end_s;
}

std::size_t Pace::slowest(const Parts& parts) const {
  const auto steps = static_cast<double>(std::max<std::size_t>(1, report_.slack_us.size()));
  std::size_t longest = 0, worst = 0;
  const auto excess_s = [&](std::size_t i) { return parts[i] - sums_s_[i] / steps; };
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (parts[i] > parts[longest]) longest = i;
    if (excess_s(i) > excess_s(worst)) worst = i;
  }
  return excess_s(worst) > 0.0 ? worst : longest;
}

}  // namespace tandem
