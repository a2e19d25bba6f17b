#include "orchestrator/commands.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "orchestrator/bench_fem_command.h"
#include "orchestrator/compare.h"
#include "orchestrator/fem_command.h"
#include "orchestrator/log_export.h"
#include "orchestrator/model.h"
#include "orchestrator/replay.h"
#include "orchestrator/run.h"
#include "orchestrator/run_directory.h"
#include "orchestrator/scenario_table.h"
#include "orchestrator/text_file.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/scenario_file.h"
#include "protocol/wire/event_log.h"
#include "protocol/wire/republish.h"

namespace tandem::orchestrator {
namespace {

/// Options that every command on a scenario has.
struct ScenarioOptions {
  std::string file;
  std::vector<std::string> sets;
  std::string scheme;
  std::string driver;
  std::string out;

  void declare(CLI::App& command) {
    command.add_option("SCENARIO", file, "Scenario file (YAML)")->required();
    command.add_option("--set", sets, "Override one key: --set coupling.scheme=implicit")
        ->type_name("KEY=VALUE")
        ->take_all();
    command.add_option("--driver", driver, "Process that runs the scheme: mbs or orchestrator");
  }

  [[nodiscard]] Model load() const {
    std::vector<scenario::Override> overrides;
    for (const std::string& set : sets) overrides.push_back(scenario::parse_override(set));
    if (!scheme.empty()) overrides.push_back({"coupling.scheme", scheme});
    if (!driver.empty()) overrides.push_back({"wire.driver", driver});
    return load_model(file, overrides);
  }
  [[nodiscard]] std::optional<std::filesystem::path> folder() const {
    return out.empty() ? std::nullopt : std::optional<std::filesystem::path>(out);
  }
};

struct RunCommand {
  ScenarioOptions scenario;
  std::string transport = "lcm";
  bool monolithic = false;
  bool attach = false;
  bool quiet = false;

  [[nodiscard]] Mode mode() const {
    require(!(monolithic && attach), "--attach: a monolithic run has no side processes to start");
    if (monolithic) return Mode::Monolithic;
    return transport == "lcm" ? Mode::Lcm : Mode::Inproc;
  }

  int run() const {
    const Model model = scenario.load();
    const RunDirectory directory = RunDirectory::create(scenario.folder(), model.name);
    const RunOutcome outcome =
        run_model(model, directory, {.mode = mode(), .silent = quiet, .attach = attach});
    report(outcome, directory);
    return outcome.exit_code;
  }

  static void report(const RunOutcome& outcome, const RunDirectory& directory) {
    const auto& s = outcome.summary;
    if (outcome.exit_code != 0) {
      std::fprintf(stderr, "%s\n", s.at("message").get<std::string>().c_str());
    }
    if (s.contains("wall_s")) {
      std::printf(
          "%s\n",
          fmt::format("{} ({}, {}): {}, {} macro steps, {:.2f} iterations per step, "
                      "{:.3f} s wall for {:.3f} s simulated, state {}",
                      s.at("scenario").get<std::string>(), s.at("mode").get<std::string>(),
                      s.at("scheme").get<std::string>(), s.at("status").get<std::string>(),
                      s.at("macro_steps").get<std::int64_t>(),
                      s.at("iterations").at("mean").get<double>(), s.at("wall_s").get<double>(),
                      s.at("simulated_s").get<double>(), s.at("state_hash").get<std::string>())
              .c_str());
    }
    const auto not_converged = s.value("not_converged_steps", std::int64_t{0});
    if (not_converged > 0) {
      std::printf(
          "%lld macro step(s) NOT converged, and accepted as coupling.on_not_converged says\n",
          static_cast<long long>(not_converged));
    }
    std::printf("run folder: %s\n", directory.path().c_str());
  }
};

void add_run(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<RunCommand>();
  CLI::App* sub = app.add_subcommand("run", "Run a coupled pair and write a run folder");
  command->scenario.declare(*sub);
  sub->add_option("--scheme", command->scenario.scheme,
                  "explicit_serial, implicit or interface_jacobian");
  sub->add_option("--out", command->scenario.out, "Run folder [runs/<scenario>/<UTC time>]");
  sub->add_option("--transport", command->transport, "lcm: two processes; inproc: one")
      ->check(CLI::IsMember({"lcm", "inproc"}))
      ->capture_default_str();
  sub->add_flag("--monolithic", command->monolithic,
                "One process, one coupled system per step: the reference for cost and error");
  sub->add_flag("--attach", command->attach,
                "Do not start the sides: print how to start them by hand (debugger)");
  sub->add_flag("--quiet", command->quiet, "No progress and no forwarded logs");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

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

struct ReplayCommand {
  std::string run;
  std::string side;
  std::string transport = "lcm";
  double tolerance = 0.0;
  bool publish = false;
  double speed = 1.0;
  std::string url;

  int replay_command() const {
    const RunDirectory directory = RunDirectory::open(run);
    require(publish != !side.empty(), "replay: choose one of --side mbs, --side fem and --publish");
    if (publish) return publish_log(directory);
    const ReplayReport report =
        replay(directory, {.side = side == "mbs" ? wire::SideName::Mbs : wire::SideName::Fem,
                           .mode = transport == "lcm" ? Mode::Lcm : Mode::Inproc,
                           .tolerance = tolerance});
    if (!report.difference.empty()) {
      throw Error(ErrorKind::ReplayDiffers, "replay: " + report.difference);
    }
    std::printf(
        "replay of %s reproduces the log%s: %lld macro steps, %lld calls (%lld discarded)\n",
        side.c_str(), tolerance > 0.0 ? " within the tolerance" : " bit for bit",
        static_cast<long long>(report.macro_steps), static_cast<long long>(report.calls),
        static_cast<long long>(report.discarded_calls));
    if (!report.remark.empty()) std::fprintf(stderr, "note: %s\n", report.remark.c_str());
    return 0;
  }

  int publish_log(const RunDirectory& directory) const {
    wire::LogReader log(directory.log());
    const std::int64_t events = wire::republish(log, url, speed);
    std::printf("published %lld events\n", static_cast<long long>(events));
    return 0;
  }
};

void add_replay(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<ReplayCommand>();
  CLI::App* sub = app.add_subcommand(
      "replay", "Drive one real side from a run's log, or publish the log on LCM again");
  sub->add_option("RUN", command->run, "Run folder")->required();
  sub->add_option("--side", command->side, "Side to drive: mbs or fem")
      ->check(CLI::IsMember({"mbs", "fem"}));
  sub->add_option("--tolerance", command->tolerance,
                  "Allowed difference relative to max(1, |logged|); 0 = the same bits")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--transport", command->transport, "lcm: a side process; inproc: none")
      ->check(CLI::IsMember({"lcm", "inproc"}))
      ->capture_default_str();
  sub->add_flag("--publish", command->publish, "Publish the log's events on LCM");
  sub->add_option("--speed", command->speed, "With --publish: 2 = twice as fast, 0 = no pauses")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--url", command->url,
                  "With --publish: LCM URL [LCM_DEFAULT_URL, else LCM's own]");
  sub->footer(
      "Exit code 5 and the first differing step, port and component when a replay differs.");
  sub->callback([command, &exit_code] { exit_code = command->replay_command(); });
}

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

void add_schema(CLI::App& app) {
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

}  // namespace

void add_commands(CLI::App& app, int& exit_code) {
  add_run(app, exit_code);
  add_compare(app, exit_code);
  add_replay(app, exit_code);
  add_fem(app, exit_code);
  add_bench(app);
  add_log(app);
  add_check(app);
  add_schema(app);
}

}  // namespace tandem::orchestrator
