#include "orchestrator/scenario/scenario_options.h"

#include <CLI/CLI.hpp>

#include "orchestrator/scenario/late_changes.h"
#include "protocol/scenario/scenario_file.h"

namespace tandem::orchestrator {

void ScenarioOptions::declare(CLI::App& command) {
  command.add_option("SCENARIO", file, "Scenario file (YAML)")->required();
  command.add_option("--set", sets, "Override one key: --set coupling.scheme=implicit")
      ->type_name("KEY=VALUE")
      ->take_all();
  command.add_option("--driver", driver, "Process that runs the scheme: mbs or orchestrator");
}

std::vector<scenario::Override> ScenarioOptions::overrides() const {
  std::vector<scenario::Override> overrides;
  for (const std::string& set : sets) overrides.push_back(scenario::parse_override(set));
  overrides.insert(overrides.end(), changes.begin(), changes.end());
  if (!scheme.empty()) {
    overrides.push_back({"coupling.scheme", scheme, scheme_option + " " + scheme});
  }
  if (!driver.empty()) overrides.push_back({"wire.driver", driver, "--driver " + driver});
  return overrides;
}

Model ScenarioOptions::load() const {
  Model model = load_model(file, overrides());
  if (!ends_early) {
    refuse_late_changes(model.scenario.root, model.run, model.coupling.adaptive.active());
  }
  return model;
}

}  // namespace tandem::orchestrator
