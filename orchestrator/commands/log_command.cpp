#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "orchestrator/commands/commands.h"
#include "orchestrator/files/run_directory.h"
#include "orchestrator/record/log_export.h"

namespace tandem::orchestrator {

void add_log(CLI::App& app) {
  auto run = std::make_shared<std::string>();
  auto csv = std::make_shared<bool>(false);
  CLI::App* sub = app.add_subcommand("log", "Describe a run's exchange log, or export it");
  sub->add_option("RUN", *run, "Run folder")->required();
  sub->add_flag("--csv", *csv,
                "Write every exchange, discarded ones too, as CSV to standard output");
  sub->callback([run, csv] {
    const RunDirectory directory = RunDirectory::open(*run);
    if (*csv) return export_csv(directory, stdout);
    std::printf("%s", describe_log(directory).c_str());
  });
}

}  // namespace tandem::orchestrator
