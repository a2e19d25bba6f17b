#include "orchestrator/commands/commands.h"

#include "orchestrator/commands/fem_command.h"

namespace tandem::orchestrator {

void add_commands(CLI::App& app, int& exit_code) {
  add_run(app, exit_code);
  add_compare(app, exit_code);
  add_advise(app);
  add_replay(app, exit_code);
  add_fem(app, exit_code);
  add_bench(app);
  add_report(app);
  add_control(app);
  add_log(app);
  add_trace(app);
  add_check(app);
  add_keys(app);
}

}  // namespace tandem::orchestrator
