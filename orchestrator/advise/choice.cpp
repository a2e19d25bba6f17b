#include "orchestrator/advise/choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tandem::orchestrator {
namespace {

constexpr double kLeastOrder = 0.5, kGreatestOrder = 3.0;
/// Wall times that differ by less are taken for equal.
constexpr double kSameWall = 1.1;
/// What a cause keeps of itself with half the step or less, if the step is not what it comes from.
constexpr double kStubborn = 0.9;
constexpr double kFurthest = 0.02;

}  // namespace

Prospect prospect_of(const TrialNumbers& trial, const ChoiceLimits& limits) {
  Prospect prospect;
  if (!trial.solved || !(trial.half_error_m > 0.0) || !(trial.error_m > limits.reference_error_m)) {
    return prospect;
  }
  prospect.known = true;
  prospect.order =
      std::clamp(std::log2(trial.error_m / trial.half_error_m), kLeastOrder, kGreatestOrder);
  const double step_s =
      trial.step_s * std::pow(limits.wanted_m / trial.error_m, 1.0 / prospect.order);
  prospect.step_s = nice_step_below(std::max(limits.shortest_s, std::min(step_s, limits.longest_s)),
                                    limits.run_s);
  prospect.wall_per_s = trial.wall_per_step_s / prospect.step_s;
  return prospect;
}

std::optional<std::size_t> cheapest(const std::vector<Prospect>& prospects,
                                    std::optional<std::size_t> own) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < prospects.size(); ++i) {
    if (!(prospects[i].step_s > 0.0)) continue;
    if (!best || prospects[i].wall_per_s < prospects[*best].wall_per_s) best = i;
  }
  if (best && own && prospects[*own].step_s > 0.0 &&
      prospects[*own].wall_per_s <= kSameWall * prospects[*best].wall_per_s) {
    return own;
  }
  return best;
}

double shortened(double step_s, const std::vector<Objection>& objections, double run_s) {
  double factor = 0.5;
  for (const Objection& objection : objections) {
    if (!(objection.limit > 0.0) || !std::isfinite(objection.value)) continue;
    factor = std::min(factor, std::pow(objection.limit / objection.value, 1.0 / objection.power));
  }
  return nice_step_below(step_s * std::max(kFurthest, factor), run_s);
}

bool stubborn(const Objection& now, double step_s, const std::vector<Objection>& before,
              double before_step_s) {
  if (now.name == "not_solved" || step_s > 0.5 * before_step_s * (1.0 + 1e-9)) return false;
  const auto same = std::find_if(before.begin(), before.end(),
                                 [&](const Objection& then) { return then.name == now.name; });
  return same != before.end() && now.value > kStubborn * same->value;
}

int severity(const std::vector<Objection>& objections) {
  int worst = 0;
  for (const Objection& objection : objections) {
    worst = std::max(worst, objection.name == "accuracy"     ? 1
                            : objection.name == "not_solved" ? 3
                                                             : 2);
  }
  return worst;
}

bool own_is_better(const Standing& own, const Standing& recommended, double accuracy) {
  if (!own.whole || own.severity > recommended.severity) return false;
  if (own.error > std::max(accuracy, recommended.error)) return false;
  return own.wall_per_s <= recommended.wall_per_s;
}

double nice_below(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {5.0, 2.0, 1.0}) {
    if (digit * decade <= value * (1.0 + 1e-9))
      return std::stod(fmt::format("{:.0e}", digit * decade));
  }
  return decade;
}

bool divides(double step_s, double run_s) {
  const std::int64_t step_ns = std::llround(step_s * 1e9);
  return step_ns > 0 && std::abs(step_s * 1e9 - static_cast<double>(step_ns)) < 1e-6 &&
         std::llround(run_s * 1e9) % step_ns == 0;
}

double nice_step_below(double value, double run_s) {
  const double first = nice_below(value);
  for (double step_s = first; step_s > 0.1 * value; step_s = nice_below(0.99 * step_s)) {
    if (divides(step_s, run_s)) return step_s;
  }
  return first;
}

}  // namespace tandem::orchestrator
