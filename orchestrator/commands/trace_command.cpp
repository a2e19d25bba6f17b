#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "orchestrator/commands/commands.h"
#include "orchestrator/files/run_directory.h"
#include "orchestrator/record/trace.h"

namespace tandem::orchestrator {

void add_trace(CLI::App& app) {
  struct Options {
    std::string run, out, steps;
  };
  auto options = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand(
      "trace", "Where the time of a run went: critical path, and a trace for ui.perfetto.dev");
  sub->add_option("RUN", options->run, "Run folder")->required();
  sub->add_option("-o,--out", options->out, "The trace (RUN/trace.json when not given)");
  sub->add_option(
      "--steps", options->steps,
      "Macro steps in the trace, as 200:300 (the first 1000 when not given); the summary "
      "is of all");
  sub->callback([options] {
    const RunDirectory run = RunDirectory::open(options->run);
    const StepWindow window =
        options->steps.empty() ? StepWindow{0, kTracedSteps} : window_of(options->steps);
    const std::string file =
        options->out.empty() ? (run.path() / "trace.json").string() : options->out;
    std::printf("%s", trace(run, file, window).c_str());
  });
}

}  // namespace tandem::orchestrator
