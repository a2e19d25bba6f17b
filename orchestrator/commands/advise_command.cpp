#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>

#include "orchestrator/advise/advise.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/files/run_directory.h"
#include "orchestrator/scenario/option_checks.h"
#include "orchestrator/scenario/scenario_options.h"
#include "protocol/contract/whole_file.h"

namespace tandem::orchestrator {
namespace {

struct AdviseCommand {
  ScenarioOptions scenario;
  AdviseOptions options;

  /// A step or duration of 0 keeps the scenario's. Steps are equal, so that they have a limit.
  [[nodiscard]] Model load(const Settings& settings, double step_s, double duration_s) const {
    ScenarioOptions changed = scenario;
    changed.sets.emplace_back("coupling.adaptive.tolerance=0");
    changed.sets.emplace_back("run.pace=free");
    changed.sets.emplace_back("output.energy_every_steps=1");
    changed.sets.emplace_back("output.bodies_every_steps=1");
    changed.sets = joined(std::move(changed.sets), settings);
    if (step_s > 0.0) changed.sets = joined(std::move(changed.sets), step_settings(own(), step_s));
    if (duration_s > 0.0) {
      changed.sets.push_back(fmt::format("run.duration_s={}", duration_s));
      changed.ends_early = true;
    }
    return changed.load();
  }

  void run() {
    own_ = scenario.load();
    const RunDirectory directory =
        RunDirectory::create_group(scenario.folder(), own().name, "advise");
    options.folder = directory.path();
    const Advice advice =
        advise([this](const Settings& settings, double step_s,
                      double duration_s) { return load(settings, step_s, duration_s); },
               options);
    const std::string text = advice_text(advice, run_command());
    write_whole_file(options.folder / "advise.json", advice_json(advice).dump(2) + "\n");
    write_whole_file(options.folder / "advise.txt", text);
    std::printf("\n%s\nresults: %s\n", text.c_str(), options.folder.c_str());
  }

 private:
  [[nodiscard]] const Model& own() const { return *own_; }

  /// What runs the scenario as it was given.
  [[nodiscard]] std::string run_command() const {
    std::string command = "tandem run " + scenario.file;
    for (const std::string& set : scenario.sets) command += " --set '" + set + "'";
    return command;
  }

  std::optional<Model> own_;
};

}  // namespace

void add_advise(CLI::App& app) {
  auto command = std::make_shared<AdviseCommand>();
  CLI::App* sub = app.add_subcommand(
      "advise",
      "Measure how strongly the sides are coupled; recommend scheme, integrators, solver and step");
  command->scenario.declare(*sub);
  sub->add_option("--accuracy", command->options.accuracy,
                  "Wanted error of port positions relative to their travel")
      ->check(number_between(1e-12, 1.0))
      ->capture_default_str();
  sub->add_option("--trial-steps", command->options.trial_steps,
                  "Length of the trial runs in macro steps")
      ->check(whole_number_between(1, 1000000))
      ->capture_default_str();
  sub->add_option("--check-s", command->options.check_s,
                  "Wall time for runs of what is recommended over the scenario's length (s)")
      ->check(number_above_zero())
      ->capture_default_str();
  sub->add_option("--most-s", command->options.most_s,
                  "Wall time for everything (s); what it does not suffice for is said")
      ->check(number_above_zero())
      ->capture_default_str();
  sub->add_option("--out", command->scenario.out, "Folder [runs/<scenario>/advise-<UTC time>]");
  sub->footer("Both sides run in this process; nothing is sent.");
  sub->callback([command] { command->run(); });
}

}  // namespace tandem::orchestrator
