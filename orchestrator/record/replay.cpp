#include "orchestrator/record/replay.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "orchestrator/process/interruption.h"
#include "orchestrator/process/side_launch.h"
#include "orchestrator/record/output_difference.h"
#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"
#include "protocol/driver/side_process.h"
#include "protocol/wire/event_log.h"
#include "protocol/wire/remote_side.h"

namespace tandem::orchestrator {
namespace {

using wire::CallKind;
using wire::CallRecord;
using wire::Process;
using wire::SideName;

std::string read_text(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Input and output of a call, by side.
template <class In>
const Segment<In>& inputs(const CallRecord& call);
template <>
const Segment<WrenchSet>& inputs(const CallRecord& call) {
  return call.wrenches;
}
template <>
const Segment<MotionSet>& inputs(const CallRecord& call) {
  return call.motions;
}

/// Makes a logged call again; the difference of what comes out, or nothing.
template <class In, class Out>
std::string repeat(const CallRecord& call, Subsystem<In, Out>& side,
                   const std::vector<std::string>& ports, double tolerance) {
  if (call.checkpoint_first) side.checkpoint();
  if (call.rollback_first) side.rollback();
  if (call.kind == CallKind::Command) {
    const CommandResult result = side.command(call.command);
    if (result.accepted == (call.outcome == Outcome::Done)) return {};
    return fmt::format("command '{}': logged as {}, replayed: {}", call.command,
                       call.outcome == Outcome::Done ? "accepted" : "refused", result.message);
  }
  const Segment<In>& input = inputs<In>(call);
  const Out& logged = inputs<Out>(call).end;
  if (call.kind == CallKind::Initialize) {
    return first_difference(logged, side.initialize(input.end), ports, tolerance);
  }
  const StepResult<Out> result =
      side.advance({.step = call.step, .input = input, .linearize = call.linearize});
  if (result.outcome != call.outcome) {
    return fmt::format("logged outcome {}, replayed {} ({})", static_cast<int>(call.outcome),
                       static_cast<int>(result.outcome), result.message);
  }
  if (call.outcome == Outcome::Failed) return {};
  return first_difference(logged, result.output, ports, tolerance);
}

/// Replays all calls of the side's kind.
template <class In, class Out>
void replay_log(wire::LogReader& log, Subsystem<In, Out>& side, SideName name,
                const std::vector<std::string>& ports, double tolerance, ReplayReport& report) {
  while (const auto journal = log.next_step()) {
    throw_if_interrupted();
    for (const CallRecord& call : journal->calls) {
      if (call.side != name) continue;
      const std::string misfit = wire::misfit(call, ports.size());
      require(misfit.empty(), fmt::format("the log is damaged: {}.", misfit));
      const std::string difference = repeat(call, side, ports, tolerance);
      ++report.calls;
      report.discarded_calls += call.accepted ? 0 : 1;
      if (difference.empty()) continue;
      report.difference =
          fmt::format("{}: differs at macro step {}, iteration {}, {}", wire::text_of(name),
                      call.macro_step, call.iteration, difference);
      return;
    }
    report.macro_steps = journal->step.macro_step;
  }
}

/// Runs `use` with the side as a process of its own, driven from here.
template <class Remote, class Use>
void with_process(const Model& model, const std::filesystem::path& folder, Process side, Use use) {
  const RunDirectory directory = RunDirectory::create_anew(folder);
  write_whole_file(directory.scenario(), model.scenario.resolved_yaml);
  wire::BusOptions options;
  options.self = Process::Orchestrator;
  options.run_id = wire::random_run_id();
  options.port = wire::free_port();
  wire::Bus bus(options);
  wire::Heartbeat heartbeat(bus, model.wire.timeout_s);
  heartbeat.set_phase("replaying");
  SideLaunch launch({side}, directory, options.run_id, options.port, false, false);
  try {
    wire::LivenessMonitor start(bus, {side}, model.wire.start_timeout_s);
    while (!start.heard_from(side)) {
      start.wait(0.02);
      launch.supervise({side});
    }
  } catch (const Error&) {
    launch.end_all(1.0);
    throw;
  }
  wire::LivenessMonitor monitor(bus, {side}, model.wire.timeout_s);
  monitor.also_watch([&] { launch.supervise({side}); });
  Remote remote(bus, monitor,
                {.side = side,
                 .scenario_hash = model.scenario.hash,
                 .port_names = model.port_names,
                 .tandem_version = kTandemVersion});
  use(remote);
  monitor.also_watch({});
  remote.close();
  launch.end_all(model.wire.timeout_s);
}

/// Why there is no more in the log; empty for a run that was done.
std::string remark_on_end(const RunDirectory& run, const wire::LogReader& log,
                          std::int64_t macro_steps) {
  if (log.truncated()) {
    return fmt::format(
        "{} ends behind macro step {} without its last event: the recording process was killed, "
        "or the file is cut",
        run.log().string(), macro_steps);
  }
  const wire::Finished& end = *log.finished();
  if (end.exit_code == 0) return {};
  return fmt::format("the recorded run ended behind macro step {} with exit code {}: {}",
                     macro_steps, end.exit_code, end.message);
}

/// Macro steps that summary.json of a finished run promises.
std::optional<std::int64_t> promised_steps(const RunDirectory& run) {
  std::ifstream stream(run.summary());
  const auto summary = nlohmann::json::parse(stream, nullptr, false);
  if (summary.is_discarded() || summary.value("status", "") != "done") return std::nullopt;
  return summary.value("macro_steps", std::int64_t{0});
}

void replay_side(const RunDirectory& run, const ReplayOptions& options, wire::LogReader& log,
                 ReplayReport& report) {
  const Model model = load_model(run.scenario(), {{"wire.driver", "orchestrator"}});
  const auto check = [&](auto& side) {
    replay_log(log, side, options.side, model.port_names, options.tolerance, report);
  };
  if (options.mode == Mode::Inproc) {
    if (options.side == SideName::Mbs) return check(*make_mbs(model, {}));
    return check(*make_fem(model, {}));
  }
  const auto folder = run.path() / fmt::format("replay-{}", wire::text_of(options.side));
  if (options.side == SideName::Mbs) {
    with_process<wire::RemoteMbs>(model, folder, Process::Mbs, check);
  } else {
    with_process<wire::RemoteFem>(model, folder, Process::Fem, check);
  }
}

}  // namespace

void require_whole_log(const RunDirectory& run) {
  const Model model = load_model(run.scenario(), {});
  const scenario::Node& root = model.scenario.root;
  const std::int64_t every = scenario::read_output(root).log_every_steps;
  if (every == 1) return;
  root.section("output").fail(
      "log_every_steps",
      fmt::format("is {}: {} holds {}, and a replay needs every exchange from the first on. Run "
                  "anew with 1, the default.",
                  every, run.log().string(),
                  every == 0 ? "no exchange" : fmt::format("one macro step of {} alone", every)));
}

ReplayReport replay(const RunDirectory& run, const ReplayOptions& options) {
  const InterruptionGuard guard;
  wire::LogReader log(run.log());
  require(log.scenario().scenario_yaml == read_text(run.scenario()),
          fmt::format("{} is not the scenario that {} was recorded with. Restore it, or run anew.",
                      run.scenario().string(), run.log().string()));
  require_whole_log(run);
  ReplayReport report;
  replay_side(run, options, log, report);
  if (!report.difference.empty()) return report;
  report.remark = remark_on_end(run, log, report.macro_steps);
  const auto promised = promised_steps(run);
  require(!promised || report.remark.empty(),
          fmt::format("{}; summary.json says that it was done after {} macro steps. Restore the "
                      "file, or run anew.",
                      report.remark, promised.value_or(0)));
  require(report.macro_steps > 0,
          fmt::format("{} holds no macro step: nothing was recorded that could be replayed; {}",
                      run.log().string(), report.remark));
  return report;
}

}  // namespace tandem::orchestrator
