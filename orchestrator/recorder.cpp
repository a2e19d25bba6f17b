#include "orchestrator/recorder.h"

#include <fmt/format.h>

#include "orchestrator/interruption.h"
#include "protocol/driver/side_process.h"

namespace tandem::orchestrator {

Recorder::Recorder(const Model& model, const RunDirectory& directory, std::uint64_t run_id,
                   bool silent)
    : log_(directory.log(), run_id,
           {.scenario_yaml = model.scenario.resolved_yaml,
            .versions = fmt::format("tandem {}", kTandemVersion)}),
      tables_(directory.path(), model.port_names),
      progress_(model.name, model.run.macro_steps(), model.run.macro_step, silent) {
  write_text_file(directory.scenario(), model.scenario.resolved_yaml);
}

double Recorder::record(wire::StepJournal journal) {
  log_.write(journal);
  tables_.write(journal);
  if (watch_) watch_(accepted_interface(journal));
  recorded_steps_ = journal.step.macro_step;
  progress_.step(journal.step.macro_step, journal.step.iterations);
  throw_if_interrupted();
  return 0.0;
}

void Recorder::finish(const wire::Finished& finished) { log_.write(finished); }

void Recorder::flush() {
  progress_.finish();
  tables_.flush();
}

}  // namespace tandem::orchestrator
