#include "orchestrator/record/path_book.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace tandem::orchestrator {
namespace {

constexpr std::size_t kSlowest = 3;

double length(const Interval& time) { return std::max(0.0, time.end_s - time.begin_s); }

/// Adds to `sums` what the path was at during `intervals`; both are in order.
void add_by_place(const std::vector<Interval>& intervals, const std::vector<PathPiece>& path,
                  std::vector<double>& sums) {
  std::size_t at = 0;
  for (const Interval& interval : intervals) {
    while (at < path.size() && path[at].time.end_s <= interval.begin_s) ++at;
    for (std::size_t i = at; i < path.size() && path[i].time.begin_s < interval.end_s; ++i) {
      sums[path[i].place] += length({std::max(path[i].time.begin_s, interval.begin_s),
                                     std::min(path[i].time.end_s, interval.end_s)});
    }
  }
}

/// What is left of `whole` besides the busy intervals, which are put in order.
std::vector<Interval> idle_of(const Interval& whole, std::vector<Interval> busy) {
  std::sort(busy.begin(), busy.end(),
            [](const Interval& a, const Interval& b) { return a.begin_s < b.begin_s; });
  std::vector<Interval> idle;
  double from_s = whole.begin_s;
  for (const Interval& interval : busy) {
    if (interval.begin_s > from_s) idle.push_back({from_s, interval.begin_s});
    from_s = std::max(from_s, interval.end_s);
  }
  if (whole.end_s > from_s) idle.push_back({from_s, whole.end_s});
  return idle;
}

std::vector<double> divided(std::vector<double> values, double by) {
  for (double& value : values) value = by > 0.0 ? value / by : 0.0;
  return values;
}

}  // namespace

std::vector<double> shares_of(const std::vector<PathPiece>& path, std::size_t workers) {
  std::vector<double> place_s(workers + kTolls, 0.0);
  for (const PathPiece& piece : path) place_s[piece.place] += length(piece.time);
  return divided(place_s, std::accumulate(place_s.begin(), place_s.end(), 0.0));
}

std::string largest_shares(const std::vector<double>& shares,
                           const std::vector<std::string>& places, std::size_t most) {
  std::vector<std::size_t> order(shares.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return shares[a] > shares[b]; });
  std::string text;
  for (std::size_t i = 0; i < std::min(most, order.size()); ++i) {
    if (shares[order[i]] < 0.01) break;
    text += fmt::format("{}{} {:.0f} %", text.empty() ? "" : ", ", places[order[i]],
                        100.0 * shares[order[i]]);
  }
  return text;
}

PathBook::PathBook(const std::vector<std::string>& workers, std::vector<bool> here)
    : places_(workers), here_(std::move(here)) {
  for (std::size_t toll = 0; toll < kTolls; ++toll) {
    places_.emplace_back(tandem::orchestrator::text_of(static_cast<Toll>(toll)));
  }
  place_s_.resize(places_.size());
  led_.resize(places_.size());
  half_s_.resize(workers.size());
  none_s_.resize(workers.size());
  wait_s_.assign(1 + workers.size(), std::vector<double>(places_.size()));
}

void PathBook::add(std::int64_t macro_step, const StepTimes& step,
                   const std::vector<PathPiece>& path) {
  if (path.empty()) return;
  ++steps_;
  const double duration_s = length(step.whole);
  total_s_ += duration_s;
  for (const PathPiece& piece : path) {
    place_s_[piece.place] += length(piece.time);
    if (piece.discarded) discarded_s_ += length(piece.time);
  }
  for (std::size_t w = 0; w < here_.size(); ++w) {
    half_s_[w] += duration_if(step, w, 0.5);
    none_s_[w] += duration_if(step, w, 0.0);
  }
  book_waits(step, path);
  std::vector<double> shares = shares_of(path, here_.size());
  const auto leader = std::max_element(shares.begin(), shares.end());
  ++led_[static_cast<std::size_t>(leader - shares.begin())];
  if (slowest_.size() == kSlowest && duration_s <= slowest_.back().duration_s) return;
  const auto place = std::find_if(slowest_.begin(), slowest_.end(), [&](const SlowStep& slow) {
    return slow.duration_s < duration_s;
  });
  slowest_.insert(place, {macro_step, duration_s, std::move(shares)});
  if (slowest_.size() > kSlowest) slowest_.pop_back();
}

void PathBook::book_waits(const StepTimes& step, const std::vector<PathPiece>& path) {
  std::vector<Interval> waiting;
  std::vector<std::vector<Interval>> busy(here_.size());
  for (const Errand& errand : step.errands) {
    if (errand.here) continue;
    if (errand.arrived_s > errand.awaited_s)
      waiting.push_back({errand.awaited_s, errand.arrived_s});
    busy[errand.worker].push_back(
        {errand.start_s - errand.decode_s, errand.end_s + errand.encode_s});
  }
  // Replies are waited for one after the other, whatever the order of the calls.
  std::sort(waiting.begin(), waiting.end(),
            [](const Interval& a, const Interval& b) { return a.begin_s < b.begin_s; });
  add_by_place(waiting, path, wait_s_[0]);
  for (std::size_t w = 0; w < here_.size(); ++w) {
    if (here_[w]) continue;
    add_by_place(idle_of(step.whole, std::move(busy[w])), path, wait_s_[1 + w]);
  }
}

std::vector<double> PathBook::shares() const { return divided(place_s_, total_s_); }

double PathBook::discarded_share() const { return total_s_ > 0.0 ? discarded_s_ / total_s_ : 0.0; }

std::vector<std::vector<double>> PathBook::waits() const {
  std::vector<std::vector<double>> waits;
  for (std::size_t row = 0; row < wait_s_.size(); ++row) {
    const bool own = row == 0 || !here_[row - 1];
    waits.push_back(own ? divided(wait_s_[row], total_s_) : std::vector<double>{});
  }
  return waits;
}

std::vector<double> PathBook::led() const {
  std::vector<double> led(led_.begin(), led_.end());
  return divided(std::move(led), static_cast<double>(steps_));
}

std::vector<PathBook::Prediction> PathBook::predictions() const {
  std::vector<Prediction> predictions;
  for (std::size_t w = 0; w < here_.size() && total_s_ > 0.0; ++w) {
    predictions.push_back({w, half_s_[w] / total_s_, none_s_[w] / total_s_});
  }
  std::stable_sort(
      predictions.begin(), predictions.end(),
      [](const Prediction& a, const Prediction& b) { return a.twice_as_fast < b.twice_as_fast; });
  return predictions;
}

std::string text_of(const PathBook& book, const std::string& driver) {
  const auto& places = book.places();
  const std::vector<double> shares = book.shares();
  const std::vector<double> led = book.led();
  const double mean_us = 1e6 * book.total_s() / static_cast<double>(book.steps());
  std::string text =
      fmt::format("critical path of {} macro steps, {:.1f} µs each\n", book.steps(), mean_us);
  text += fmt::format("  {:<16} {:>7} {:>10} {:>18}\n", "", "share", "µs/step", "largest in steps");
  for (std::size_t p = 0; p < places.size(); ++p) {
    text += fmt::format("  {:<16} {:>5.1f} % {:>10.2f} {:>16.1f} %\n", places[p], 100.0 * shares[p],
                        mean_us * shares[p], 100.0 * led[p]);
  }
  text += fmt::format("  of which {:.1f} % was rolled back\n", 100.0 * book.discarded_share());

  text += "who waits, for what\n";
  const auto waits = book.waits();
  for (std::size_t row = 0; row < waits.size(); ++row) {
    if (waits[row].empty()) continue;
    const double sum = std::accumulate(waits[row].begin(), waits[row].end(), 0.0);
    text +=
        fmt::format("  {:<16} {:>5.1f} % {}{}\n", row == 0 ? driver : places[row - 1], 100.0 * sum,
                    sum < 0.01 ? "" : "  for ", largest_shares(waits[row], places, 4));
  }

  text += "what to speed up first\n";
  for (const PathBook::Prediction& prediction : book.predictions()) {
    text += fmt::format(
        "  {:<16} twice as fast: the run takes {:.3f} of its time; in no time: {:.3f}\n",
        places[prediction.worker], prediction.twice_as_fast, prediction.in_no_time);
  }

  text += "slowest macro steps\n";
  for (const PathBook::SlowStep& slow : book.slowest()) {
    text += fmt::format("  {:<16} {:>10.1f} µs: {}\n", slow.macro_step, 1e6 * slow.duration_s,
                        largest_shares(slow.shares, places));
  }
  return text;
}

}  // namespace tandem::orchestrator
