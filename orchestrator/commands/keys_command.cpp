#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "orchestrator/commands/commands.h"
#include "orchestrator/scenario/scenario_table.h"
#include "protocol/scenario/scenario_file.h"

namespace tandem::orchestrator {

void add_keys(CLI::App& app) {
  CLI::App* sub = app.add_subcommand(
      "keys", "Print the scenario reference page or the JSON Schema for editors");
  auto schema = std::make_shared<bool>(false);
  sub->add_flag("--schema", *schema, "JSON Schema (draft 2020-12) in place of the Markdown page");
  sub->callback([schema] {
    const auto& table = scenario_table();
    const std::string text = *schema ? scenario::json_schema(table, "Tandem scenario")
                                     : scenario::reference_markdown(table, "Scenario reference");
    std::printf("%s", text.c_str());
  });
}

}  // namespace tandem::orchestrator
