#include "orchestrator/advise/explicit_limit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

constexpr int kFinerSteps = 6;         // the ratios are measured from H/2⁶ …
constexpr int kCoarserSteps = 3;       // … to 2³ H
constexpr int kTrialSteps = 300;       // a slow instability needs time to show
constexpr double kBracketRatio = 1.2;  // how closely the limit is enclosed

/// Steps are whole nanoseconds, and of a number that micro steps divide.
double whole_step(double step_s) {
  const double grain_ns = step_s > 2e-5 ? 1000.0 : 16.0;
  return std::max(1.0, std::round(step_s * 1e9 / grain_ns)) * grain_ns * 1e-9;
}

double predicted_limit(const std::vector<InterfaceRatios>& ratios, Prediction prediction) {
  double limit_s = 0.0, below = 0.0;
  for (const InterfaceRatios& entry : ratios) {
    const double amplification = explicit_amplification(entry, prediction);
    if (amplification >= 1.0) {
      if (limit_s == 0.0 || below <= 0.0) return limit_s;
      // Between the two steps, on logarithmic scales.
      const double part = std::log(1.0 / below) / std::log(amplification / below);
      return limit_s * std::pow(entry.step_s / limit_s, part);
    }
    limit_s = entry.step_s;
    below = amplification;
  }
  return limit_s;
}

}  // namespace

std::vector<InterfaceRatios> ratios_over_step(const LoadTrial& load, double step_s) {
  std::vector<InterfaceRatios> ratios;
  for (int level = -kFinerSteps; level <= kCoarserSteps; ++level) {
    const double h_s = level == 0 ? step_s : whole_step(std::ldexp(step_s, level));
    const Model model = load({}, h_s, h_s);
    const auto mbs = make_mbs(model, {});
    const auto fem = make_fem(model, {});
    try {
      ratios.push_back(measure_ratios(*mbs, *fem, model.run.macro_step));
    } catch (const Error& error) {
      // Longer steps than the scenario's may be too long for a side: the range ends before.
      if (error.kind() != ErrorKind::NotSolved || level <= 0) throw;
      break;
    }
  }
  return ratios;
}

ExplicitLimit explicit_limit(const LoadTrial& load, const std::vector<InterfaceRatios>& ratios,
                             Prediction prediction, const std::filesystem::path& folder,
                             double deadline_s) {
  ExplicitLimit limit{.predicted_s = predicted_limit(ratios, prediction)};
  const double least_s = ratios.front().step_s, greatest_s = ratios.back().step_s;
  const auto book = [&](double wanted_s) {
    const double h_s = whole_step(wanted_s);
    const ObservedRun run =
        observe_run(load({"coupling.scheme=explicit_serial"}, h_s, kTrialSteps * h_s), Mode::Inproc,
                    folder / "stability" / fmt::format("{}", h_s),
                    fmt::format("stability: explicit_serial, H = {:g} s", h_s), deadline_s);
    limit.out_of_time = run.out_of_time;
    if (!run.out_of_time) (run.exit_code == 0 ? limit.stable_s : limit.unstable_s) = h_s;
  };
  double h_s = limit.predicted_s > 0.0 ? limit.predicted_s : std::sqrt(least_s * greatest_s);
  book(h_s);
  const auto open = [&] { return !limit.out_of_time; };
  while (open() && limit.unstable_s == 0.0 && h_s < greatest_s) book(h_s *= 2.0);
  while (open() && limit.stable_s == 0.0 && h_s > least_s) book(h_s *= 0.5);
  while (open() && limit.stable_s > 0.0 && limit.unstable_s > kBracketRatio * limit.stable_s) {
    const double between_s = whole_step(std::sqrt(limit.stable_s * limit.unstable_s));
    if (between_s <= limit.stable_s || between_s >= limit.unstable_s) break;
    book(between_s);
  }
  return limit;
}

}  // namespace tandem::orchestrator
