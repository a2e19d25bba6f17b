#include "orchestrator/run/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "orchestrator/process/interruption.h"
#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"
#include "protocol/driver/side_process.h"
#include "protocol/scenario/common_keys.h"

namespace tandem::orchestrator {

Recorder::Recorder(const Model& model, const RunDirectory& directory, std::uint64_t run_id,
                   bool silent)
    : log_(directory.log(), run_id,
           {.scenario_yaml = model.scenario.resolved_yaml,
            .versions = fmt::format("tandem {}", kTandemVersion)}),
      log_every_steps_(scenario::read_output(model.scenario.root).log_every_steps),
      tables_(directory.path(), model.port_names, part_names(model)),
      progress_(model.name, model.run.macro_steps(), model.run.macro_step, silent) {
  so_far_.broken_off = true;
  so_far_.port_names = model.port_names;
  write_whole_file(directory.scenario(), model.scenario.resolved_yaml);
}

double Recorder::record(wire::StepJournal journal) {
  for (const wire::CallRecord& call : journal.calls) {
    const bool received = journal.received.message != nullptr;
    const std::string misfit = wire::misfit(call, so_far_.port_names.size(), received);
    if (!misfit.empty()) throw Error(ErrorKind::Partner, "orchestrator: " + misfit + ".");
  }
  if (logs(journal)) {
    log_is_whole_ = false;
    log_.write(journal);
    log_is_whole_ = true;
  } else {
    log_.require_still_there();
  }
  tables_.write(journal);
  AcceptedInterface accepted = accepted_interface(journal);
  if (watch_) watch_(accepted);
  recorded_steps_ = journal.step.macro_step;
  book(journal.step, std::move(accepted));
  progress_.step(journal.step.macro_step, journal.step.iterations);
  throw_if_interrupted();
  return 0.0;
}

void Recorder::rest(double seconds) {
  throw_if_interrupted();
  StepSink::rest(seconds);
}

/// Of a thinned log: the steps in turn and what a reader will look for, the steps that were
/// commanded or failed.
bool Recorder::logs(const wire::StepJournal& journal) const {
  if (log_every_steps_ == 0) return false;
  if (journal.step.macro_step % log_every_steps_ == 0) return true;
  return journal.step.outcome == Outcome::Failed ||
         std::any_of(journal.calls.begin(), journal.calls.end(), [](const wire::CallRecord& call) {
           return call.kind == wire::CallKind::Command;
         });
}

void Recorder::book(const wire::StepRecord& step, AcceptedInterface accepted) {
  if (step.macro_step > 0) {
    const double power_W = interface_power_W(accepted.wrenches, accepted.motions);
    so_far_.book(step);
    if (step.outcome != Outcome::Failed) {
      so_far_.book_interface(step.energy_defect_J, to_seconds(step.step) * std::abs(power_W));
    }
    so_far_.ledger += step.ledger;
    so_far_.wall_s += step.ledger.named_s() + step.ledger.other_s;
  }
  if (step.outcome == Outcome::Failed) return;
  so_far_.macro_steps = step.macro_step;
  so_far_.simulated = step.time;
  so_far_.motions = std::move(accepted.motions);
  so_far_.wrenches = std::move(accepted.wrenches);
}

void Recorder::finish(const wire::Finished& finished) {
  if (!log_is_whole_) return;
  log_is_whole_ = false;
  log_.write(finished);
}

void Recorder::flush() {
  progress_.finish();
  tables_.flush();
}

}  // namespace tandem::orchestrator
