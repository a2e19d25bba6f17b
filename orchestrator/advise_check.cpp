#include "orchestrator/advise_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orchestrator/body_rates.h"
#include "orchestrator/csv_table.h"
#include "orchestrator/verdict/verdict.h"
#include "protocol/contract/cost.h"

namespace tandem::orchestrator {
namespace {

constexpr double kMostTurn_rad = VerdictLimits::kTurn_rad;
constexpr double kMostChange = 0.2;
constexpr int kMostTrials = 20;
constexpr const char* kOutOfTime = "out_of_time";  // see observe_run
/// What a step takes more than was foreseen, once a trial has not come to its end.
constexpr double kSlower = 4.0;
/// Fewer macro steps than this say nothing of a run.
constexpr double kFewestSteps = 20.0;

double largest_rate_rad_per_s(const History& history, const std::filesystem::path& folder) {
  double largest = 0.0;
  for (const AcceptedInterface& entry : history) {
    for (const Motion& motion : entry.motions) largest = std::max(largest, motion.w_WP.norm());
  }
  return std::max(largest, fastest_body(folder / "bodies.csv").rate_rad_per_s);
}

double elastic_peak_J(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "energy.csv";
  if (!std::filesystem::exists(file)) return 0.0;
  double peak = 0.0;
  const CsvTable energy(file);
  for (const double value : energy.column("fem.elastic_J")) peak = std::max(peak, value);
  return peak;
}

/// How long a trial goes on: a whole number of steps, the run's length where the time allows.
double trial_length_s(double step_s, double length_s, double steps_in_time) {
  const double whole = std::max(1.0, std::round(length_s / step_s));
  return step_s * std::min(whole, std::floor(steps_in_time));
}

StepTrial try_step(const LoadTrial& load, const StepCheckOptions& options, double step_s,
                   double length_s, int number, double deadline_s) {
  StepTrial trial{.step_s = step_s, .simulated_s = length_s};
  const auto run = [&](double h_s) {
    const std::filesystem::path folder = options.folder / fmt::format("{}-{}", number, h_s);
    ObservedRun made =
        observe_run(load(options.scheme, h_s, length_s), Mode::Inproc, folder,
                    fmt::format("check: {}, H = {:g} s over {:g} s", options.scheme, h_s, length_s),
                    deadline_s);
    trial.wall_s += made.summary.at("wall_s").get<double>();
    return std::pair{std::move(made), folder};
  };
  const auto [whole, folder] = run(step_s);
  trial.status = whole.summary.at("status").get<std::string>();
  trial.turn_rad = step_s * largest_rate_rad_per_s(whole.history, folder);
  trial.elastic_peak_J = elastic_peak_J(folder);
  if (!trial.objection().empty()) return trial;
  const auto [half, half_folder] = run(0.5 * step_s);
  if (half.out_of_time) trial.status = half.summary.at("status").get<std::string>();
  trial.elastic_peak_half_J = elastic_peak_J(half_folder);
  const std::vector<PortInfo> ports = make_fem(load("", step_s, step_s), {})->info().ports;
  const double travel_m = largest_travel_m(half.history, ports);
  if (travel_m > 0.0) {
    trial.port_change = motion_distance(whole.history, half.history, ports).motion_m / travel_m;
  }
  return trial;
}

}  // namespace

double nice_below(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {5.0, 2.0, 1.0}) {
    if (digit * decade <= value * (1.0 + 1e-9))
      return std::stod(fmt::format("{:.0e}", digit * decade));
  }
  return decade;
}

double StepTrial::elastic_change() const {
  const double larger = std::max(elastic_peak_J, elastic_peak_half_J);
  if (elastic_peak_half_J == 0.0 || larger == 0.0) return 0.0;
  return std::abs(elastic_peak_J - elastic_peak_half_J) / larger;
}

std::string StepTrial::objection() const {
  if (status != "done") return "it ends as " + status;
  if (turn_rad > kMostTurn_rad * (1.0 + 1e-9)) {
    return fmt::format("something turns by {:.2g} rad per step", turn_rad);
  }
  if (elastic_change() > kMostChange) {
    return fmt::format(
        "the flexible body's largest elastic energy is {:.3g} J, with half the step "
        "{:.3g} J",
        elastic_peak_J, elastic_peak_half_J);
  }
  return "";
}

StepCheck check_step(const LoadTrial& load, const StepCheckOptions& options) {
  StepCheck check;
  double step_s = options.step_s;
  const double end_s = now_s() + options.most_s;
  double per_step_s = options.wall_per_step_s;
  for (int n = 0; n < kMostTrials && step_s >= options.shortest_s; ++n) {
    // A step and two halves of it, in half of the time that is left: a trial that takes longer than
    // was foreseen is made again, over less.
    const double allowed_s = 0.5 * std::max(0.0, end_s - now_s());
    const double length_s =
        trial_length_s(step_s, options.length_s, allowed_s / (3.0 * per_step_s));
    const double asked = std::round(options.length_s / step_s);
    if (length_s < std::min(kFewestSteps, asked) * step_s * (1.0 - 1e-9)) return check;
    const StepTrial trial = try_step(load, options, step_s, length_s, n + 1, now_s() + allowed_s);
    if (trial.status == kOutOfTime) {
      per_step_s *= kSlower;
      continue;
    }
    check.trials.push_back(trial);
    per_step_s = std::max(per_step_s, trial.wall_s * step_s / (3.0 * length_s));
    if (trial.objection().empty()) {
      check.step_s = step_s;
      check.whole_run = length_s > options.length_s * (1.0 - 1e-9) - 0.5 * step_s;
      return check;
    }
    double next_s = nice_below(0.5 * step_s);
    if (trial.status == "done" && trial.turn_rad > kMostTurn_rad) {
      next_s = std::min(next_s, nice_below(step_s * kMostTurn_rad / trial.turn_rad));
    }
    step_s = next_s;
  }
  return check;
}

}  // namespace tandem::orchestrator
