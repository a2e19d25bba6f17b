#include "orchestrator/advise/step_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "orchestrator/files/csv_table.h"
#include "orchestrator/files/summary_number.h"

namespace tandem::orchestrator {
namespace {

/// A half that was broken off before is no run to compare with.
constexpr double kFewestHalvedSteps = 20.0;

/// What comes from the model and not from its steps.
bool of_the_model(const std::string& cause) { return cause == "elastic_turn"; }

Objection objection_of(const nlohmann::ordered_json& cause, double order) {
  const std::string name = cause.at("name").get<std::string>();
  return {.name = name,
          // What is not finite is null there.
          .value = cause.at("value").is_number() ? cause.at("value").get<double>()
                                                 : std::numeric_limits<double>::infinity(),
          .limit = cause.at("threshold").get<double>(),
          .power = name == "turn_per_step" ? 1.0 : std::max(1.0, order),
          .text = cause.at("text").get<std::string>(),
          .remedy = cause.at("remedy").get<std::string>()};
}

/// 0 where the run with half the step has nothing to compare with.
double change_of(double peak, double half_peak) {
  return half_peak == 0.0 ? 0.0 : std::abs(peak - half_peak) / std::max(peak, half_peak);
}

void compare(const JudgedRun& run, JudgedRun& half, const std::vector<PortInfo>& ports,
             const StepQuestion& question, StepTrial& trial) {
  trial.simulated_s = std::min(run.simulated_s, half.simulated_s);
  trial.elastic_peak_J = run.elastic_peak_J(trial.simulated_s);
  trial.elastic_peak_half_J = half.elastic_peak_J(trial.simulated_s);
  if (trial.elastic_change() > kMostElasticChange) {
    trial.objections.push_back(
        {.name = "elastic_peak",
         .value = trial.elastic_change(),
         .limit = kMostElasticChange,
         .power = question.order,
         .text = fmt::format("the flexible body's largest elastic energy "
                             "is {:.3g} J, with half the step {:.3g} J",
                             trial.elastic_peak_J, trial.elastic_peak_half_J),
         .remedy = ""});
  }
  trial.wrench_peak_N = largest_wrench_N(run.history, ports, trial.simulated_s);
  trial.wrench_peak_half_N = largest_wrench_N(half.history, ports, trial.simulated_s);
  if (trial.wrench_change() > kMostWrenchChange) {
    trial.objections.push_back({.name = "wrench_peak",
                                .value = trial.wrench_change(),
                                .limit = kMostWrenchChange,
                                .power = question.order,
                                .text = fmt::format("the largest wrench at the ports is {:.3g} N, "
                                                    "with half the step {:.3g} N",
                                                    trial.wrench_peak_N, trial.wrench_peak_half_N),
                                .remedy = ""});
  }
  const double travel_m = largest_travel_m(half.history, ports);
  trial.port_change =
      travel_m > 0.0 ? motion_distance(run.history, half.history, ports).motion_m / travel_m : 0.0;
  // e(H) = c Hᵖ and e(H) − e(H/2) is what was seen.
  const double doubled = std::exp2(question.order);
  trial.error = trial.port_change * doubled / (doubled - 1.0);
  if (trial.error > question.accuracy) {
    trial.objections.push_back(
        {.name = "accuracy",
         .value = trial.error,
         .limit = question.accuracy,
         .power = question.order,
         .text =
             fmt::format("the error of the port motions is {:.2g} of their travel", trial.error),
         .remedy = ""});
  }
  trial.half = std::move(half.history);
}

}  // namespace

double JudgedRun::elastic_peak_J(double until_s) const {
  const std::filesystem::path file = folder / "energy.csv";
  if (!std::filesystem::exists(file)) return 0.0;
  const CsvTable energy(file);
  const std::vector<double> t_s = energy.column("t_s");
  const std::vector<double> elastic_J = energy.column("fem.elastic_J");
  double peak = 0.0;
  for (std::size_t i = 0; i < elastic_J.size(); ++i) {
    if (t_s[i] <= until_s * (1.0 + 1e-9)) peak = std::max(peak, elastic_J[i]);
  }
  return peak;
}

JudgedRun judged_run(const Model& model, const std::filesystem::path& folder,
                     const std::string& title, double deadline_s) {
  ObservedRun made = observe_run(model, Mode::Inproc, folder, title, deadline_s);
  JudgedRun run{.status = made.summary.at("status").get<std::string>(),
                .message = made.summary.at("message").get<std::string>(),
                .simulated_s = number_at(made.summary, "simulated_s"),
                .wall_s = number_at(made.summary, "wall_s"),
                .verdict = made.summary.at("verdict"),
                .history = std::move(made.history),
                .folder = folder};
  if (run.verdict.contains("largest_turn_rad")) {
    run.turn_rad = number_at(run.verdict, "largest_turn_rad");
  }
  return run;
}

double largest_wrench_N(const History& history, const std::vector<PortInfo>& ports,
                        double until_s) {
  double largest = 0.0;
  for (const AcceptedInterface& at : history) {
    if (to_seconds(at.time) > until_s * (1.0 + 1e-9)) break;
    largest = std::max(largest, wrench_norm_N(at.wrenches, ports));
  }
  return largest;
}

double StepTrial::elastic_change() const { return change_of(elastic_peak_J, elastic_peak_half_J); }

double StepTrial::wrench_change() const { return change_of(wrench_peak_N, wrench_peak_half_N); }

std::vector<Objection> objections_to(const JudgedRun& run, double order) {
  if (run.status != "done") {
    return {{.name = "not_solved",
             .value = std::numeric_limits<double>::infinity(),
             .limit = 0.0,
             .power = 1.0,
             .text = "it ends as " + run.status,
             .remedy = ""}};
  }
  std::vector<Objection> objections;
  for (const auto& cause : run.verdict.at("causes")) {
    objections.push_back(objection_of(cause, order));
  }
  return objections;
}

StepTrial try_step(const LoadTrial& load, const std::vector<PortInfo>& ports,
                   const StepQuestion& question) {
  StepTrial trial{.name = question.name,
                  .settings = question.settings,
                  .step_s = question.step_s,
                  .simulated_s = question.length_s,
                  .whole = question.whole};
  const auto run = [&](double step_s) {
    return judged_run(
        load(question.settings, step_s, question.whole ? 0.0 : question.length_s),
        question.folder / fmt::format("{:g}", step_s),
        fmt::format("check: {}, H = {:g} s over {:g} s", question.name, step_s, question.length_s),
        question.deadline_s);
  };
  const JudgedRun whole = run(question.step_s);
  trial.status = whole.status;
  trial.wall_s = whole.wall_s;
  trial.wall_per_s = whole.wall_per_s();
  trial.turn_rad = whole.turn_rad;
  trial.verdict = whole.verdict;
  if (whole.status == kOutOfTime) return trial;
  trial.objections = objections_to(whole, question.order);
  const auto model_is_first = std::stable_partition(
      trial.objections.begin(), trial.objections.end(),
      [](const Objection& objection) { return !of_the_model(objection.name); });
  trial.told.assign(model_is_first, trial.objections.end());
  trial.objections.erase(model_is_first, trial.objections.end());
  if (severity(trial.objections) == 3) return trial;
  if (!trial.objections.empty() && !question.half_in_any_case) return trial;
  JudgedRun half = run(0.5 * question.step_s);
  trial.wall_s += half.wall_s;
  if (half.status == kOutOfTime) {
    if (half.simulated_s < std::min(kFewestHalvedSteps * trial.step_s, 0.5 * whole.simulated_s)) {
      trial.status = kOutOfTime;
      return trial;
    }
    trial.whole = false;
  } else if (half.status != "done") {
    trial.objections = objections_to(half, question.order);
    trial.objections.front().text = "with half the step " + trial.objections.front().text;
    return trial;
  }
  if (half.history.size() > 1) compare(whole, half, ports, question, trial);
  return trial;
}

}  // namespace tandem::orchestrator
