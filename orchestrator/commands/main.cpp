// tandem: the command line. Each subcommand fills its options and calls one function.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "orchestrator/commands/commands.h"
#include "orchestrator/process/interruption.h"
#include "protocol/contract/error.h"
#include "protocol/driver/process_memory.h"
#include "protocol/driver/side_process.h"
#include "protocol/driver/standard_streams.h"
#include "protocol/scenario/node.h"

namespace {

/// CLI11 says of a mistyped command only that one is required. `argv` begins with the name of
/// `app`.
void require_known_command(const CLI::App& app, int argc, char** argv) {
  const std::string given = argc > 1 ? argv[1] : "--help";
  if (given.starts_with('-')) return;
  std::vector<std::string> known;
  std::string list;
  for (const CLI::App* command : app.get_subcommands({})) {
    known.push_back(command->get_name());
    list += (list.empty() ? "" : ", ") + command->get_name();
  }
  tandem::require(std::find(known.begin(), known.end(), given) != known.end(),
                  app.get_name() + ": '" + given + "' is not a command." +
                      tandem::scenario::did_you_mean(given, known) + " Commands: " + list + ".");
  const CLI::App& command = *app.get_subcommand(given);
  const bool only_commands = command.get_options().size() == 1;  // --help
  if (only_commands && !command.get_subcommands({}).empty()) {
    require_known_command(command, argc - 1, argv + 1);
  }
}

/// CLI11 says of a mistyped option only that it was not expected, before the words behind it. Empty
/// when all options are known.
std::string unknown_option(const CLI::App& app, int argc, char** argv) {
  const CLI::App* command = &app;
  for (std::vector<CLI::App*> below = command->get_subcommands(); !below.empty();
       below = command->get_subcommands()) {
    command = below.front();
  }
  std::vector<std::string> known;
  for (const CLI::App* level = command; level != nullptr; level = level->get_parent()) {
    for (const CLI::Option* option : level->get_options()) {
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    }
  }
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::string given = word.substr(0, word.find('='));
    if (!given.starts_with("--") || std::find(known.begin(), known.end(), given) != known.end()) {
      continue;
    }
    return command->get_name() + ": there is no option '" + given + "'." +
           tandem::scenario::did_you_mean(given, known) + " Run with --help for all.";
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  using namespace tandem;
  open_standard_streams();
  keep_freed_memory();
  CLI::App app(
      "Couples a rigid multibody process (ODE) with a flexible-body process (co-rotational finite\n"
      "elements) over LCM, measures what the coupling costs, and replays what was exchanged.",
      "tandem");
  app.set_version_flag("--version", kTandemVersion);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done · 2 bad usage or scenario · 3 not converged or diverged ·\n"
      "            4 a process failed or stopped answering · 5 replay differs ·\n"
      "            130 interrupted (Ctrl-C), 143 terminated.\n"
      "Start with:  tandem run examples/lug/scenario.yaml");
  int exit_code = 0;
  orchestrator::add_commands(app, exit_code);
  try {
    require_known_command(app, argc, argv);
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError& error) {
    const std::string unknown = unknown_option(app, argc, argv);
    if (unknown.empty()) return app.exit(error) == 0 ? 0 : 2;
    std::fprintf(stderr, "%s\n", unknown.c_str());
    return 2;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    const int signal = orchestrator::stop_signal();
    return signal != 0 ? 128 + signal : error.exit_code();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem: %s\n", error.what());
    return 4;
  }
  return exit_code;
}
