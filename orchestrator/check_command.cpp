#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "orchestrator/commands.h"
#include "orchestrator/model.h"
#include "orchestrator/scenario_options.h"

namespace tandem::orchestrator {

void add_check(CLI::App& app) {
  auto options = std::make_shared<ScenarioOptions>();
  CLI::App* sub = app.add_subcommand(
      "check",
      "Validate a scenario with its mesh: file:line:column, what is wrong, what would be right");
  options->declare(*sub);
  sub->callback([options] {
    const Model model = options->load();
    const auto mbs = make_mbs(model, {});
    const auto fem = make_fem(model, {});
    std::printf("%s\n", fmt::format("{}: good. {} macro steps of {} s, {} port(s), scheme {}",
                                    options->file, model.run.macro_steps(),
                                    to_seconds(model.run.macro_step), model.port_names.size(),
                                    to_string(model.coupling.scheme))
                            .c_str());
  });
}

}  // namespace tandem::orchestrator
