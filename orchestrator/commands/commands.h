#pragma once

namespace CLI {
class App;
}

namespace tandem::orchestrator {

/// Declares all subcommands. Each runs while the command line is parsed and sets `exit_code`;
/// errors of the user and of the machine are thrown as tandem::Error.
void add_commands(CLI::App& app, int& exit_code);

// One subcommand each, in a file of its name.
void add_run(CLI::App& app, int& exit_code);
void add_compare(CLI::App& app, int& exit_code);
void add_advise(CLI::App& app);
void add_replay(CLI::App& app, int& exit_code);
void add_report(CLI::App& app);
void add_bench(CLI::App& app);
void add_control(CLI::App& app);
void add_log(CLI::App& app);
void add_trace(CLI::App& app);
void add_check(CLI::App& app);
void add_keys(CLI::App& app);

}  // namespace tandem::orchestrator
