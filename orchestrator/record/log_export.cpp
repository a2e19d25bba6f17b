#include "orchestrator/record/log_export.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <iterator>

#include "orchestrator/run/step_tables.h"
#include "orchestrator/scenario/model.h"
#include "protocol/contract/error.h"
#include "protocol/wire/event_log.h"

namespace tandem::orchestrator {
namespace {

const char* text_of(wire::CallKind kind) {
  switch (kind) {
    case wire::CallKind::Initialize:
      return "initialize";
    case wire::CallKind::Advance:
      return "advance";
    case wire::CallKind::Command:
      return "command";
  }
  return "unknown";
}

/// A cell of any text (RFC 4180).
std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + '"';
}

/// `begin`: the accepted time that the call sets out from. An attempt that an adaptive step rejects
/// has an H, and so an end, of its own.
std::string call_row(const wire::CallRecord& call, SimTime begin, std::size_t ports) {
  AcceptedInterface interface { begin + call.step, call.motions.end, call.wrenches.end };
  std::string values = interface_row(interface);
  if (interface.motions.empty() && interface.wrenches.empty()) {
    values.insert(values.size() - 1, std::string(19 * ports, ','));
  }
  return fmt::format("{},{},{},{},{},{},{},{},{},", call.macro_step, call.iteration,
                     wire::text_of(call.side), text_of(call.kind), call.accepted ? 1 : 0,
                     call.rollback_first ? 1 : 0, static_cast<int>(call.outcome),
                     to_seconds(call.step), quoted(call.command)) +
         values;
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
  put(out, "macro_step,iteration,side,kind,accepted,rollback,outcome,H_s,command," +
               interface_header(model.port_names));
  SimTime begin{};
  std::int64_t last = -1;
  while (const auto journal = log.next_step()) {
    const wire::StepRecord& step = journal->step;
    // Behind steps that the log leaves out (output.log_every_steps).
    if (step.macro_step > last + 1) begin = step.time - step.step;
    last = step.macro_step;
    for (const wire::CallRecord& call : journal->calls) {
      const std::string misfit = wire::misfit(call, model.port_names.size());
      require(misfit.empty(), fmt::format("{} is damaged: {}.", run.log().string(), misfit));
      put(out, call_row(call, begin, model.port_names.size()));
    }
    begin = step.time;
  }
  if (std::fflush(out) != 0) put(out, "\n");
}

std::string describe_log(const RunDirectory& run) {
  wire::LogReader log(run.log());
  std::int64_t steps = 0, calls = 0, discarded = 0, logged = -1;  // the initial values are step 0
  std::string commands;
  while (const auto journal = log.next_step()) {
    steps = journal->step.macro_step;
    ++logged;
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
  const std::string thinned =
      logged < 0        ? ", none is here (output.log_every_steps: 0, or the run never began)"
      : logged == steps ? ""
                        : fmt::format(", of which {} stand here (output.log_every_steps)", logged);
  return fmt::format(
      "{}\n  run id       {:016x}\n  written by   {}\n  macro steps  {}{}\n  calls        {} ({} "
      "discarded by rollback)\n{}  ends         {}\n",
      run.log().string(), log.run_id(), log.scenario().versions, steps, thinned, calls, discarded,
      commands, end_of(log, steps));
}

}  // namespace tandem::orchestrator
