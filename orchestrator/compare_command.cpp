#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "orchestrator/commands.h"
#include "orchestrator/compare.h"
#include "orchestrator/run_directory.h"
#include "orchestrator/scenario_options.h"
#include "orchestrator/text_file.h"

namespace tandem::orchestrator {
namespace {

struct CompareCommand {
  ScenarioOptions scenario;
  std::int64_t repeat = 3;
  std::vector<std::string> schemes;

  int run() const {
    const auto load = [this](const std::string& scheme) {
      ScenarioOptions options = scenario;
      options.scheme = scheme;
      return options.load();
    };
    const CompareOptions options{
        .repeat = repeat,
        .schemes = schemes,
        .folder = RunDirectory::create_group(scenario.folder(), load("").name, "compare")};
    const Comparison comparison = compare(load, options);
    const std::string table = compare_table(comparison);
    write_text_file(options.folder / "compare.json", compare_json(comparison).dump(2) + "\n");
    write_text_file(options.folder / "compare.txt", table);
    std::printf("\n%s\nresults: %s\n", table.c_str(), options.folder.c_str());
    int exit_code = 0;
    for (const ComparedRuns& runs : comparison.runs)
      exit_code = std::max(exit_code, runs.exit_code);
    return exit_code;
  }
};

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<CompareCommand>();
  CLI::App* sub = app.add_subcommand(
      "compare", "Run monolithic, in process and over LCM in turn; print cost and accuracy");
  command->scenario.declare(*sub);
  sub->add_option("--repeat", command->repeat, "Interleaved repetitions")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--schemes", command->schemes, "Schemes to compare [the scenario's own]")
      ->delimiter(',');
  sub->add_option("--out", command->scenario.out, "Folder [runs/<scenario>/compare-<UTC time>]");
  sub->footer("Wall times are those of the stepping loop. Exit code 3 when a run was not solved.");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace tandem::orchestrator
