#include "orchestrator/advise/solver_trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "orchestrator/advise/candidates.h"
#include "orchestrator/run/observed_run.h"
#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

constexpr double kFewestSolvedSteps = 20.0, kMostSteps = 60.0;
constexpr double kRepetitions = 2.0;
constexpr double kSaves = 0.9;   // part of the wall time without the change
constexpr double kMoves = 0.01;  // part of the wanted error
constexpr double kNever = std::numeric_limits<double>::infinity();

/// One way of running the candidate, repeated.
struct Way {
  std::string name;
  Settings settings;  ///< beside those of the candidate
  std::string status = "done";
  double wall_per_step_s = kNever;
  History history;
};

void run(const LoadTrial& load, const SolverQuestion& question, double steps, int repetition,
         Way& way) {
  ObservedRun made = observe_run(
      load(joined(question.settings, way.settings), question.step_s, steps * question.step_s),
      Mode::Inproc, question.folder / fmt::format("{} {}", way.name, repetition),
      fmt::format("solver: {}, {}, H = {:g} s", question.name, way.name, question.step_s),
      question.deadline_s);
  way.status = made.summary.at("status").get<std::string>();
  way.wall_per_step_s =
      std::min(way.wall_per_step_s, made.summary.at("wall_s").get<double>() / steps);
  way.history = std::move(made.history);
}

/// What the model refuses is no way to solve it.
void run_once(const LoadTrial& load, const SolverQuestion& question, double steps, int repetition,
              Way& way) {
  if (way.status != "done") return;
  try {
    run(load, question, steps, repetition, way);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::Usage) throw;
    way.status = "refused";
  }
}

SolverTrial compared(const Way& way, const Way& without, const std::vector<PortInfo>& ports,
                     const SolverQuestion& question) {
  SolverTrial trial{.name = way.name,
                    .settings = way.settings,
                    .status = way.status,
                    .step_s = question.step_s,
                    .wall_per_step_s = way.wall_per_step_s,
                    .without_wall_per_step_s = without.wall_per_step_s};
  if (way.status != "done" || without.status != "done") return trial;
  const double travel_m = largest_travel_m(without.history, ports);
  const double moved_m = motion_distance(way.history, without.history, ports).motion_m;
  trial.change = travel_m > 0.0 ? moved_m / travel_m : 0.0;
  trial.taken = trial.wall_per_step_s <= kSaves * without.wall_per_step_s &&
                trial.change <= kMoves * question.accuracy;
  return trial;
}

/// The taken changes together in place of the best one, if that saves more.
void try_together(const LoadTrial& load, const std::vector<PortInfo>& ports,
                  const SolverQuestion& question, double steps, const Way& without,
                  std::vector<SolverTrial>& trials) {
  if (std::count_if(trials.begin(), trials.end(), [](const auto& t) { return t.taken; }) < 2) {
    return;
  }
  Way both{.name = "together", .settings = taken_settings(trials), .history = {}};
  run_once(load, question, steps, 1, both);
  SolverTrial together = compared(both, without, ports, question);
  const auto best = std::min_element(
      trials.begin(), trials.end(),
      [](const auto& a, const auto& b) { return a.wall_per_step_s < b.wall_per_step_s; });
  together.taken = together.taken && together.wall_per_step_s < best->wall_per_step_s;
  for (auto trial = trials.begin(); trial != trials.end(); ++trial) {
    trial->taken = !together.taken && trial == best;
  }
  trials.push_back(std::move(together));
}

}  // namespace

std::vector<SolverTrial> try_solvers(const LoadTrial& load, const std::vector<PortInfo>& ports,
                                     const SolverQuestion& question) {
  const Model model = load(question.settings, question.step_s, question.step_s);
  std::vector<Way> ways;
  for (const SolverChange& change : solver_changes(model)) {
    ways.push_back({.name = change.name, .settings = change.settings, .history = {}});
  }
  const double runs = kRepetitions * static_cast<double>(1 + ways.size());
  const double affordable =
      (question.deadline_s - now_s()) / (runs * std::max(1e-9, question.wall_per_step_s));
  const double asked = std::round(question.length_s / question.step_s);
  const double steps = std::floor(std::min({kMostSteps, asked, affordable}));
  if (ways.empty() || steps < std::min(kFewestSolvedSteps, asked)) return {};
  Way without{.name = "without", .settings = {}, .history = {}};
  for (int repetition = 1; repetition <= kRepetitions; ++repetition) {
    run_once(load, question, steps, repetition, without);
    for (Way& way : ways) run_once(load, question, steps, repetition, way);
  }
  std::vector<SolverTrial> trials;
  for (const Way& way : ways) trials.push_back(compared(way, without, ports, question));
  try_together(load, ports, question, steps, without, trials);
  return trials;
}

Settings taken_settings(const std::vector<SolverTrial>& trials) {
  Settings settings;
  for (const SolverTrial& trial : trials) {
    if (trial.taken) settings = joined(std::move(settings), trial.settings);
  }
  return settings;
}

}  // namespace tandem::orchestrator
