// tandem: the command line. Each subcommand fills its options and calls one function.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "orchestrator/commands.h"
#include "orchestrator/interruption.h"
#include "protocol/contract/error.h"
#include "protocol/driver/side_process.h"
#include "protocol/driver/standard_streams.h"

int main(int argc, char** argv) {
  using namespace tandem;
  open_standard_streams();
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
    app.parse(argc, argv);
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
