#include "orchestrator/log_export.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <iterator>

#include "orchestrator/model.h"
#include "orchestrator/step_tables.h"
#include "protocol/contract/error.h"
#include "protocol/wire/event_log.h"

namespace tandem::orchestrator {
namespace {

std::string call_row(const wire::CallRecord& call, SimTime time) {
  return fmt::format(
             "{},{},{},{},{},{},{},", call.macro_step, call.iteration, wire::text_of(call.side),
             call.kind == wire::CallKind::Initialize ? "initialize" : "advance",
             call.accepted ? 1 : 0, call.rollback_first ? 1 : 0, static_cast<int>(call.outcome)) +
         interface_row({time, call.motions.end, call.wrenches.end});
}

void put(std::FILE* out, const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), out) != text.size()) {
    throw Error(ErrorKind::System,
                fmt::format("cannot write the export: {}", std::strerror(errno)));
  }
}

std::string end_of(const wire::LogReader& log, std::int64_t steps) {
  if (!log.finished()) {
    return fmt::format(
        "without its last event, behind macro step {}: the recording process was killed, or the "
        "file is cut",
        steps);
  }
  const wire::Finished& end = *log.finished();
  if (end.exit_code == 0) return "done";
  return fmt::format("behind macro step {} with exit code {}: {}", steps, end.exit_code,
                     end.message);
}

}  // namespace

void export_csv(const RunDirectory& run, std::FILE* out) {
  wire::LogReader log(run.log());
  const Model model = load_model(run.scenario(), {});
  put(out, "macro_step,iteration,side,kind,accepted,rollback,outcome," +
               interface_header(model.port_names));
  while (const auto journal = log.next_step()) {
    for (const wire::CallRecord& call : journal->calls) {
      const std::string misfit = wire::misfit(call, model.port_names.size());
      require(misfit.empty(), fmt::format("{} is damaged: {}.", run.log().string(), misfit));
      if (call.kind != wire::CallKind::Command) put(out, call_row(call, journal->step.time));
    }
  }
  if (std::fflush(out) != 0) put(out, "\n");
}

std::string describe_log(const RunDirectory& run) {
  wire::LogReader log(run.log());
  std::int64_t steps = 0, calls = 0, discarded = 0;
  std::string commands;
  while (const auto journal = log.next_step()) {
    steps = journal->step.macro_step;
    for (const wire::CallRecord& call : journal->calls) {
      if (call.kind == wire::CallKind::Command) {
        commands += fmt::format("  command      before macro step {}: {}: {}{}\n", call.macro_step,
                                call.command, call.accepted ? "" : "refused: ", call.message);
        continue;
      }
      ++calls;
      discarded += call.accepted ? 0 : 1;
    }
  }
  return fmt::format(
      "{}\n  run id       {:016x}\n  written by   {}\n  macro steps  {}\n  calls        {} ({} "
      "discarded by rollback)\n{}  ends         {}\n",
      run.log().string(), log.run_id(), log.scenario().versions, steps, calls, discarded, commands,
      end_of(log, steps));
}

}  // namespace tandem::orchestrator
