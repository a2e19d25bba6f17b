#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "orchestrator/commands/commands.h"
#include "orchestrator/files/run_directory.h"
#include "orchestrator/scenario/option_checks.h"
#include "orchestrator/scenario/scenario_options.h"
#include "orchestrator/study/compare.h"
#include "orchestrator/study/work_precision.h"
#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"

namespace tandem::orchestrator {
namespace {

struct CompareCommand {
  ScenarioOptions scenario;
  std::int64_t repeat = 0;  ///< 0: the default of the kind of comparison
  std::vector<std::string> schemes;
  std::vector<double> steps_s;
  std::vector<double> tolerances;
  std::string transport = "lcm";

  [[nodiscard]] Model load(const std::string& scheme) const {
    ScenarioOptions options = scenario;
    if (!scheme.empty()) options.scheme = scheme;
    options.scheme_option = "--schemes";
    options.sets.emplace_back("run.pace=free");  // what it costs, not how long it may take
    return options.load();
  }
  [[nodiscard]] RunDirectory new_folder() const {
    return RunDirectory::create_group(scenario.folder(), load("").name, "compare");
  }

  [[nodiscard]] int run() const { return steps_s.empty() ? compare_costs() : compare_precision(); }

  [[nodiscard]] int compare_costs() const {
    require(transport == "lcm", "--transport: compare without --steps runs both transports.");
    require(tolerances.empty(),
            "--tolerances: needs --steps; the smallest is the first of the adaptive ones.");
    const RunDirectory directory = new_folder();
    const CompareOptions options{
        .repeat = repeat > 0 ? repeat : 3, .schemes = schemes, .folder = directory.path()};
    const Comparison comparison =
        compare([this](const std::string& scheme) { return load(scheme); }, options);
    finish(options.folder, compare_json(comparison), compare_table(comparison));
    int exit_code = 0;
    for (const ComparedRuns& runs : comparison.runs)
      exit_code = std::max(exit_code, runs.exit_code);
    return exit_code;
  }

  [[nodiscard]] int compare_precision() const {
    const RunDirectory directory = new_folder();
    const WorkPrecisionOptions options{.schemes = schemes,
                                       .steps_s = steps_s,
                                       .tolerances = tolerances,
                                       .mode = transport == "lcm" ? Mode::Lcm : Mode::Inproc,
                                       .repeat = repeat > 0 ? repeat : 1,
                                       .folder = directory.path()};
    const auto load_step = [this](const std::string& scheme, double step_s, double tolerance) {
      CompareCommand stepped = *this;
      const std::string step = fmt::format("{}", step_s);
      const std::string bound = fmt::format("{}", tolerance);
      stepped.scenario.changes = {{"run.macro_step_s", step, "--steps " + step},
                                  {"coupling.adaptive.tolerance", bound, "--tolerances " + bound}};
      return stepped.load(scheme);
    };
    const WorkPrecision result = work_precision(load_step, options);
    write_whole_file(options.folder / "compare.csv", work_precision_csv(result));
    write_whole_file(options.folder / "compare.svg", work_precision_svg(result));
    finish(options.folder, work_precision_json(result), work_precision_table(result));
    return 0;
  }

  static void finish(const std::filesystem::path& folder, const nlohmann::ordered_json& json,
                     const std::string& table) {
    write_whole_file(folder / "compare.json", json.dump(2) + "\n");
    write_whole_file(folder / "compare.txt", table);
    std::printf("\n%s\nresults: %s\n", table.c_str(), folder.c_str());
  }
};

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<CompareCommand>();
  CLI::App* sub = app.add_subcommand(
      "compare", "Run monolithic, in process and over LCM in turn; print cost and accuracy");
  command->scenario.declare(*sub);
  sub->add_option("--repeat", command->repeat, "Interleaved repetitions [3; with --steps 1]")
      ->check(whole_number_between(1, 1000));
  sub->add_option("--schemes", command->schemes, "Schemes to compare [the scenario's own]")
      ->delimiter(',');
  sub->add_option(
         "--steps", command->steps_s,
         "Macro steps (s): the work-precision table of the schemes, with a fine monolithic "
         "run as reference")
      ->delimiter(',')
      ->check(number_above_zero());
  sub->add_option("--tolerances", command->tolerances,
                  "With --steps: also adaptive macro steps with these coupling.adaptive.tolerance")
      ->delimiter(',')
      ->check(number_above_zero());
  sub->add_option("--transport", command->transport, "With --steps: lcm or inproc")
      ->check(CLI::IsMember({"lcm", "inproc"}))
      ->capture_default_str();
  sub->add_option("--out", command->scenario.out, "Folder [runs/<scenario>/compare-<UTC time>]");
  sub->footer(
      "Wall times are those of the stepping loop. Exit code 3 when a run was not solved; with "
      "--steps a run that diverges is a row of the table.");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace tandem::orchestrator
