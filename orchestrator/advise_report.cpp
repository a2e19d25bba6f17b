#include <fmt/format.h>

#include <iterator>

#include "orchestrator/advise.h"

namespace tandem::orchestrator {
namespace {

using nlohmann::ordered_json;

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

ordered_json scheme_json(const SchemeAdvice& scheme) {
  return {{"scheme", scheme.scheme},
          {"status", scheme.status},
          {"error_m", scheme.error_m},
          {"order", scheme.order},
          {"exchanges_per_step", scheme.exchanges_per_step},
          {"macro_step_for_accuracy_s", scheme.step_for_accuracy_s},
          {"exchanges_per_simulated_s", scheme.exchanges_per_second}};
}

ordered_json check_json(const StepCheck& check) {
  ordered_json json = {{"macro_step_s", check.step_s},
                       {"whole_run", check.whole_run},
                       {"trials", ordered_json::array()}};
  for (const StepTrial& trial : check.trials) {
    json["trials"].push_back({{"macro_step_s", trial.step_s},
                              {"simulated_s", trial.simulated_s},
                              {"status", trial.status},
                              {"turn_rad_per_step", trial.turn_rad},
                              {"elastic_peak_J", trial.elastic_peak_J},
                              {"elastic_peak_at_half_step_J", trial.elastic_peak_half_J},
                              {"port_change", trial.port_change},
                              {"objection", trial.objection()}});
  }
  return json;
}

}  // namespace

ordered_json advice_json(const Advice& advice) {
  ordered_json json = {{"scenario", advice.scenario},
                       {"recommended",
                        {{"scheme", advice.scheme},
                         {"macro_step_s", advice.macro_step_s},
                         {"reasons", advice.reasons},
                         {"undecided", advice.undecided}}},
                       {"check", check_json(advice.check)},
                       {"accuracy", advice.accuracy},
                       {"trial_macro_step_s", advice.trial_step_s},
                       {"largest_travel_m", advice.travel_m},
                       {"explicit_stability",
                        {{"prediction", advice.prediction_name},
                         {"predicted_s", advice.limit.predicted_s},
                         {"stable_s", advice.limit.stable_s},
                         {"unstable_s", advice.limit.unstable_s}}},
                       {"ratios", ordered_json::array()},
                       {"trials", ordered_json::array()}};
  for (const InterfaceRatios& ratios : advice.ratios) {
    json["ratios"].push_back(ratios_json(ratios, advice.prediction));
  }
  for (const SchemeAdvice& scheme : advice.schemes) json["trials"].push_back(scheme_json(scheme));
  return json;
}

std::string advice_text(const Advice& advice) {
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
  fmt::format_to(std::back_inserter(text),
                 "\ntrial runs in process at H = {} s\n{:<20} {:<14} {:>11} {:>6} {:>15} {:>14} "
                 "{:>14}\n",
                 advice.trial_step_s, "scheme", "status", "error m", "order", "exchanges/step",
                 "H for accuracy", "exchanges/s");
  for (const SchemeAdvice& s : advice.schemes) {
    fmt::format_to(std::back_inserter(text),
                   "{:<20} {:<14} {:>11.3e} {:>6.2f} {:>15.2f} {:>14.4g} {:>14.0f}\n", s.scheme,
                   s.status, s.error_m, s.order, s.exchanges_per_step, s.step_for_accuracy_s,
                   s.exchanges_per_second);
  }
  fmt::format_to(std::back_inserter(text), "\nrecommended: {} with run.macro_step_s: {:g}\n",
                 advice.scheme, advice.macro_step_s);
  for (const std::string& reason : advice.reasons) {
    fmt::format_to(std::back_inserter(text), "  * {}\n", reason);
  }
  for (const std::string& open : advice.undecided) {
    fmt::format_to(std::back_inserter(text), "  not decided: {}\n", open);
  }
  return text;
}

}  // namespace tandem::orchestrator
