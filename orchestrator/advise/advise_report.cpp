#include <fmt/format.h>

#include <iterator>

#include "orchestrator/advise/advise.h"

namespace tandem::orchestrator {
namespace {

using nlohmann::ordered_json;

/// Errors below 0 are not known.
ordered_json known(double value) { return value >= 0.0 ? ordered_json(value) : ordered_json(); }

ordered_json ratios_json(const InterfaceRatios& ratios, Prediction prediction) {
  ordered_json json = {{"macro_step_s", ratios.step_s},
                       {"coupling_ratio", ratios.coupling_ratio()},
                       {"explicit_amplification", explicit_amplification(ratios, prediction)},
                       {"ports", ordered_json::array()}};
  for (const PortRatio& port : ratios.ports) {
    json["ports"].push_back({{"name", port.name},
                             {"rigid_kg", port.rigid_kg},
                             {"flexible_kg", port.flexible_kg},
                             {"mass_ratio", port.flexible_kg / port.rigid_kg},
                             {"stiffness_N_per_m", port.stiffness_N_per_m}});
  }
  return json;
}

ordered_json trials_json(const Advice& advice) {
  const Trials& trials = advice.trials;
  ordered_json json = {{"macro_step_s", trials.step_s},
                       {"simulated_s", trials.length_s},
                       {"reference",
                        {{"integrators", trials.reference_pair},
                         {"macro_step_s", trials.reference_step_s},
                         {"error_estimate_m", trials.reference_error_m}}},
                       {"largest_travel_m", trials.travel_m},
                       {"candidates", ordered_json::array()}};
  for (const TrialRow& row : trials.rows) {
    json["candidates"].push_back({{"scheme", row.candidate.scheme},
                                  {"integrators", row.candidate.pair.name},
                                  {"settings", row.candidate.settings},
                                  {"status", row.status},
                                  {"error_m", row.numbers.error_m},
                                  {"error_with_half_step_m", row.numbers.half_error_m},
                                  {"exchanges_per_step", row.exchanges_per_step},
                                  {"wall_s_per_step", row.numbers.wall_per_step_s}});
  }
  json["promised"] = ordered_json::array();
  for (const Contender& contender : advice.contenders) {
    json["promised"].push_back({{"candidate", contender.candidate.name()},
                                {"known", contender.prospect.known},
                                {"order", contender.prospect.order},
                                {"macro_step_s", contender.prospect.step_s},
                                {"wall_s_per_simulated_s", contender.prospect.wall_per_s}});
  }
  return json;
}

ordered_json texts(const std::vector<Objection>& objections) {
  ordered_json json = ordered_json::array();
  for (const Objection& objection : objections) {
    json.push_back({{"name", objection.name},
                    {"value", objection.value},
                    {"limit", objection.limit},
                    {"text", objection.text}});
  }
  return json;
}

ordered_json check_json(const StepCheck& check) {
  const StepTrial* best = check.best ? &check.trials[*check.best] : nullptr;
  ordered_json json = {{"macro_step_s", check.stands ? best->step_s : 0.0},
                       {"whole_run", check.stands && best->whole},
                       {"trials", ordered_json::array()},
                       {"solver_trials", ordered_json::array()}};
  for (const StepTrial& trial : check.trials) {
    json["trials"].push_back({{"candidate", trial.name},
                              {"settings", trial.settings},
                              {"macro_step_s", trial.step_s},
                              {"simulated_s", trial.simulated_s},
                              {"wall_s_per_simulated_s", trial.wall_per_s},
                              {"status", trial.status},
                              {"turn_rad_per_step", trial.turn_rad},
                              {"elastic_peak_J", trial.elastic_peak_J},
                              {"elastic_peak_at_half_step_J", trial.elastic_peak_half_J},
                              {"wrench_peak_N", trial.wrench_peak_N},
                              {"wrench_peak_at_half_step_N", trial.wrench_peak_half_N},
                              {"port_change", known(trial.port_change)},
                              {"error", known(trial.error)},
                              {"objections", texts(trial.objections)},
                              {"not_cured_by_shorter_steps", texts(trial.told)}});
  }
  for (const SolverTrial& trial : check.solver_trials) {
    json["solver_trials"].push_back({{"change", trial.name},
                                     {"settings", trial.settings},
                                     {"status", trial.status},
                                     {"macro_step_s", trial.step_s},
                                     {"wall_s_per_step", trial.wall_per_step_s},
                                     {"wall_s_per_step_without", trial.without_wall_per_step_s},
                                     {"change_of_ports", trial.change},
                                     {"taken", trial.taken}});
  }
  return json;
}

/// What a run costs and how good it is; null where there was none.
ordered_json measured_json(double wall_per_s, double error, double simulated_s,
                           const ordered_json& verdict) {
  return {{"simulated_s", simulated_s},
          {"wall_s_per_simulated_s", wall_per_s},
          {"error", known(error)},
          {"verdict", verdict}};
}

ordered_json recommended_json(const Advice& advice) {
  const Recommendation& made = advice.recommended;
  ordered_json json = {{"scheme", made.scheme},     {"macro_step_s", made.macro_step_s},
                       {"settings", made.settings}, {"own", made.own},
                       {"measured", nullptr},       {"own_settings_measured", nullptr},
                       {"reasons", advice.reasons}, {"undecided", advice.undecided}};
  const OwnRun& own = advice.own;
  if (own.made) {
    json["own_settings_measured"] =
        measured_json(own.wall_per_s, own.error, own.simulated_s, own.verdict);
  }
  const StepTrial* trial = advice.checked();
  if (made.own && own.made) {
    json["measured"] = json["own_settings_measured"];
  } else if (trial != nullptr) {
    json["measured"] =
        measured_json(trial->wall_per_s, trial->error, trial->simulated_s, trial->verdict);
  }
  return json;
}

std::string ratios_text(const Advice& advice) {
  std::string text = fmt::format(
      "{}: how strongly the sides are coupled\n\n{:>12} {:>16} {:>16}   per port: flexible kg / "
      "rigid kg within one step\n",
      advice.scenario, "H s", "coupling ratio", "explicit ×/step");
  for (const InterfaceRatios& ratios : advice.ratios) {
    fmt::format_to(std::back_inserter(text), "{:>12.4g} {:>16.4g} {:>16.4g}  ", ratios.step_s,
                   ratios.coupling_ratio(), explicit_amplification(ratios, advice.prediction));
    for (const PortRatio& port : ratios.ports) {
      fmt::format_to(std::back_inserter(text), " {}: {:.3g}/{:.3g}", port.name, port.flexible_kg,
                     port.rigid_kg);
    }
    text += "\n";
  }
  return text;
}

std::string trials_text(const Advice& advice) {
  const Trials& trials = advice.trials;
  if (trials.rows.empty()) return "";
  std::string text = fmt::format(
      "\ntrial runs in process at H = {} s over {:g} s, against the monolithic run at {:g} s "
      "(integrators: {})\n{:<34} {:<14} {:>11} {:>11} {:>15} {:>12}\n",
      trials.step_s, trials.length_s, trials.reference_step_s, trials.reference_pair, "candidate",
      "status", "error m", "with H/2 m", "exchanges/step", "ms/step");
  for (const TrialRow& row : trials.rows) {
    fmt::format_to(std::back_inserter(text),
                   "{:<34} {:<14} {:>11.3e} {:>11.3e} {:>15.2f} {:>12.4g}\n", row.candidate.name(),
                   row.status, row.numbers.error_m, row.numbers.half_error_m,
                   row.exchanges_per_step, 1e3 * row.numbers.wall_per_step_s);
  }
  fmt::format_to(std::back_inserter(text), "\n{:<34} {:>6} {:>14} {:>14}\n", "promised", "order",
                 "H for accuracy", "wall s per s");
  for (const Contender& contender : advice.contenders) {
    fmt::format_to(std::back_inserter(text), "{:<34} {:>6.2f} {:>14.4g} {:>14.4g}{}\n",
                   contender.candidate.name(), contender.prospect.order, contender.prospect.step_s,
                   contender.prospect.wall_per_s,
                   contender.prospect.known ? "" : "  (no error to go by)");
  }
  return text;
}

std::string check_text(const StepCheck& check) {
  std::string text;
  if (!check.solver_trials.empty()) {
    fmt::format_to(std::back_inserter(text), "\n{:<34} {:>12} {:>12} {:>12} {:>8}\n",
                   "solver settings", "H s", "ms/step", "without", "taken");
  }
  for (const SolverTrial& trial : check.solver_trials) {
    fmt::format_to(std::back_inserter(text), "{:<34} {:>12.4g} {:>12.4g} {:>12.4g} {:>8}\n",
                   trial.name, trial.step_s, 1e3 * trial.wall_per_step_s,
                   1e3 * trial.without_wall_per_step_s, trial.taken ? "yes" : "no");
  }
  return text;
}

std::string measured_line(const std::string& name, double wall_per_s, double error,
                          const ordered_json& verdict) {
  std::string judged = verdict.at("status").get<std::string>();
  for (const auto& cause : verdict.at("causes")) {
    judged += (&cause == &verdict.at("causes").front() ? " " : "; ") +
              cause.at("text").get<std::string>();
  }
  return fmt::format("  {:<26} {:>14.4g} {:>16} {}\n", name, wall_per_s,
                     error >= 0.0 ? fmt::format("{:.2g}", error) : "not known", judged);
}

std::string recommended_text(const Advice& advice, const std::string& command) {
  const Recommendation& made = advice.recommended;
  std::string text = fmt::format("\nrecommended: {} with run.macro_step_s: {:g}\n  {}", made.scheme,
                                 made.macro_step_s, command);
  for (const std::string& setting : made.settings) {
    const bool plain = setting.find_first_of(" {}[],") == std::string::npos;
    text += plain ? " --set " + setting : " --set '" + setting + "'";
  }
  text += "\n";
  const StepTrial* trial = advice.checked();
  if (trial == nullptr) return text;
  fmt::format_to(std::back_inserter(text), "\n  {:<26} {:>14} {:>16} {}\n",
                 fmt::format("over {:g} s, in process", trial->simulated_s), "wall s per s",
                 "error of travel", "verdict");
  if (!(made.own && advice.own.made)) {
    text += measured_line("recommended", trial->wall_per_s, trial->error, trial->verdict);
  }
  const OwnRun& own = advice.own;
  if (own.made) {
    text += measured_line("the scenario's settings", own.wall_per_s, own.error, own.verdict);
  }
  if (made.own && own.made) {
    text += measured_line(trial->name, trial->wall_per_s, trial->error, trial->verdict);
  }
  return text + "\n";
}

}  // namespace

ordered_json advice_json(const Advice& advice) {
  ordered_json json = {{"scenario", advice.scenario},
                       {"recommended", recommended_json(advice)},
                       {"check", check_json(advice.check)},
                       {"accuracy", advice.accuracy},
                       {"explicit_stability",
                        {{"prediction", advice.prediction_name},
                         {"predicted_s", advice.limit.predicted_s},
                         {"stable_s", advice.limit.stable_s},
                         {"unstable_s", advice.limit.unstable_s}}},
                       {"ratios", ordered_json::array()},
                       {"trials", trials_json(advice)}};
  for (const InterfaceRatios& ratios : advice.ratios) {
    json["ratios"].push_back(ratios_json(ratios, advice.prediction));
  }
  return json;
}

std::string advice_text(const Advice& advice, const std::string& command) {
  std::string text = ratios_text(advice) + trials_text(advice) + check_text(advice.check) +
                     recommended_text(advice, command);
  for (const std::string& reason : advice.reasons) text += "  * " + reason + "\n";
  for (const std::string& open : advice.undecided) text += "  not decided: " + open + "\n";
  return text;
}

}  // namespace tandem::orchestrator
