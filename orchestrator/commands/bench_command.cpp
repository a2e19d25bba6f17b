#include <CLI/CLI.hpp>

#include "orchestrator/commands/bench_exchange_command.h"
#include "orchestrator/commands/bench_fem_command.h"
#include "orchestrator/commands/commands.h"

namespace tandem::orchestrator {

void add_bench(CLI::App& app) {
  CLI::App* bench = app.add_subcommand("bench", "Measure speed with its error");
  bench->require_subcommand(1);
  add_bench_fem(*bench);
  add_bench_exchange(*bench);
}

}  // namespace tandem::orchestrator
