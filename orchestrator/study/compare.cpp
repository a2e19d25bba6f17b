#include "orchestrator/study/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

void run_once(ComparedRuns& runs, const Model& model, const CompareOptions& options,
              std::int64_t repetition) {
  ObservedRun run = observe_run(
      model, runs.mode,
      options.folder / runs.scheme / fmt::format("{}-{}", to_string(runs.mode), repetition),
      fmt::format("repetition {} of {}: {} {}", repetition, options.repeat, runs.scheme,
                  to_string(runs.mode)));
  runs.exit_code = run.exit_code;
  runs.wall_s.push_back(run.summary.at("wall_s").get<double>());
  runs.summaries.push_back(std::move(run.summary));
  runs.history = std::move(run.history);
}

void require_different(const std::vector<Model>& models) {
  for (std::size_t i = 0; i < models.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      require(models[i].coupling.scheme != models[j].coupling.scheme,
              "--schemes: " + to_string(models[i].coupling.scheme) +
                  " is named twice. Name every scheme once.");
    }
  }
}

/// The repetition in the middle (the lower one of two), so that ledger and wall time belong
/// together.
const nlohmann::ordered_json& median_summary(const ComparedRuns& runs) {
  std::vector<std::size_t> order(runs.wall_s.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return runs.wall_s[a] < runs.wall_s[b]; });
  return runs.summaries[order[(order.size() - 1) / 2]];
}

/// Both runs' values of all macro steps that both have, component by component.
template <class Visit>
void visit_pairs(const ComparedRuns& a, const ComparedRuns& b, Visit visit) {
  const std::size_t steps = std::min(a.history.size(), b.history.size());
  for (std::size_t n = 0; n < steps; ++n) {
    for (std::size_t i = 0; i < a.history[n].motions.size(); ++i) {
      visit(a.history[n].motions[i], b.history[n].motions[i], a.history[n].wrenches[i],
            b.history[n].wrenches[i]);
    }
  }
}

}  // namespace

const ComparedRuns& Comparison::find(Mode mode, const std::string& scheme) const {
  for (const ComparedRuns& run : runs) {
    if (run.mode == mode && (mode == Mode::Monolithic || run.scheme == scheme)) return run;
  }
  throw std::logic_error("comparison without " + to_string(mode) + " " + scheme);
}

Comparison compare(const std::function<Model(const std::string& scheme)>& load,
                   const CompareOptions& options) {
  std::vector<Model> models;
  for (const std::string& scheme : options.schemes) models.push_back(load(scheme));
  if (models.empty()) models.push_back(load(""));
  require_different(models);

  Comparison comparison{.scenario = models.front().name, .repeat = options.repeat};
  std::vector<const Model*> model_of;
  const auto add = [&](Mode mode, const std::string& scheme, const Model& model) {
    comparison.runs.push_back({.mode = mode, .scheme = scheme});
    model_of.push_back(&model);
  };
  add(Mode::Monolithic, "monolithic", models.front());
  for (const Model& model : models) {
    add(Mode::Inproc, to_string(model.coupling.scheme), model);
    add(Mode::Lcm, to_string(model.coupling.scheme), model);
  }
  for (std::int64_t repetition = 1; repetition <= options.repeat; ++repetition) {
    for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
      run_once(comparison.runs[i], *model_of[i], options, repetition);
    }
  }
  for (ComparedRuns& runs : comparison.runs) runs.summary = median_summary(runs);
  return comparison;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  Spread spread{.min = *least, .max = *greatest, .repetitions = values.size()};
  spread.median = median(std::move(values));
  return spread;
}

Spread ratio(const ComparedRuns& a, const ComparedRuns& b) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(a.wall_s.size(), b.wall_s.size()); ++i) {
    ratios.push_back(a.wall_s[i] / b.wall_s[i]);
  }
  return spread_of(std::move(ratios));
}

double largest_distance_m(const ComparedRuns& a, const ComparedRuns& b) {
  return motion_distance(a.history, b.history).max_m;
}

double largest_difference(const ComparedRuns& a, const ComparedRuns& b) {
  double largest = a.history.size() == b.history.size() ? 0.0 : HUGE_VAL;
  visit_pairs(a, b, [&](const Motion& m, const Motion& n, const Wrench& w, const Wrench& x) {
    largest = std::max(
        {largest, (m.p_WP - n.p_WP).cwiseAbs().maxCoeff(),
         (m.q_WP.coeffs() - n.q_WP.coeffs()).cwiseAbs().maxCoeff(),
         (m.v_WP - n.v_WP).cwiseAbs().maxCoeff(), (m.w_WP - n.w_WP).cwiseAbs().maxCoeff(),
         (w.f_P_W - x.f_P_W).cwiseAbs().maxCoeff(), (w.t_P_W - x.t_P_W).cwiseAbs().maxCoeff()});
  });
  return largest;
}

}  // namespace tandem::orchestrator
