#pragma once

namespace CLI {
class App;
}

namespace tandem::orchestrator {

/// Declares all subcommands. Each runs while the command line is parsed and sets `exit_code`;
/// errors of the user and of the machine are thrown as tandem::Error.
void add_commands(CLI::App& app, int& exit_code);

}  // namespace tandem::orchestrator
