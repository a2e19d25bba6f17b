#include "orchestrator/record/replay.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "orchestrator/process/interruption.h"
#include "orchestrator/process/side_launch.h"
#include "orchestrator/record/output_difference.h"
#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"
#include "protocol/driver/composite_side.h"
#include "protocol/driver/remote_bodies.h"
#include "protocol/driver/remote_worlds.h"
#include "protocol/driver/side_process.h"
#include "protocol/wire/event_log.h"

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

/// Which calls of a log are made again, and of what is in them.
struct Played {
  SideName side;
  std::vector<std::string> ports;
  std::optional<scenario::BodyPorts> part;  ///< one of several flexible bodies or worlds

  /// Whether the call is a command to another body: its checkpoint is made, and no more.
  [[nodiscard]] bool is_to_other(const CallRecord& call) const {
    return part && call.kind == CallKind::Command && !call.command.starts_with(part->name + " ");
  }
  /// The call, none to another body, as it came to the part.
  [[nodiscard]] CallRecord of(CallRecord call) const {
    if (!part) return call;
    if (call.kind == CallKind::Command) call.command.erase(0, part->name.size() + 1);
    for (MotionSet* set : {&call.motions.begin, &call.motions.end}) {
      *set = of_ports(*set, part->ports);
    }
    for (WrenchSet* set : {&call.wrenches.begin, &call.wrenches.end}) {
      *set = of_ports(*set, part->ports);
    }
    return call;
  }
};

/// Makes a logged call again; the difference of what comes out, or nothing.
template <class In, class Out>
std::string repeat(const CallRecord& logged_call, Subsystem<In, Out>& side, const Played& played,
                   double tolerance) {
  if (logged_call.checkpoint_first) side.checkpoint();
  if (logged_call.rollback_first) side.rollback();
  if (played.is_to_other(logged_call)) return {};
  const CallRecord call = played.of(logged_call);
  if (call.kind == CallKind::Command) {
    const CommandResult result = side.command(call.command);
    if (result.accepted == (call.outcome == Outcome::Done)) return {};
    return fmt::format("command '{}': logged as {}, replayed: {}", call.command,
                       call.outcome == Outcome::Done ? "accepted" : "refused", result.message);
  }
  const Segment<In>& input = inputs<In>(call);
  const Out& logged = inputs<Out>(call).end;
  if (call.kind == CallKind::Initialize) {
    return first_difference(logged, side.initialize(input.end), played.ports, tolerance);
  }
  const StepResult<Out> result =
      side.advance({.step = call.step, .input = input, .linearize = call.linearize});
  // The logged outcome is the worst of all parts'.
  if (played.part ? result.outcome > call.outcome : result.outcome != call.outcome) {
    return fmt::format("logged outcome {}, replayed {} ({})", static_cast<int>(call.outcome),
                       static_cast<int>(result.outcome), result.message);
  }
  if (call.outcome == Outcome::Failed) return {};
  return first_difference(logged, result.output, played.ports, tolerance);
}

/// Replays all calls of the side's kind.
template <class In, class Out>
void replay_log(wire::LogReader& log, Subsystem<In, Out>& side, const Played& played,
                const Model& model, const ReplayOptions& options, ReplayReport& report) {
  while (const auto journal = log.next_step()) {
    throw_if_interrupted();
    for (const CallRecord& call : journal->calls) {
      if (call.side != played.side) continue;
      const std::string misfit = wire::misfit(call, model.port_names.size());
      require(misfit.empty(), fmt::format("the log is damaged: {}.", misfit));
      const std::string difference = repeat(call, side, played, options.tolerance);
      ++report.calls;
      report.discarded_calls += call.accepted ? 0 : 1;
      if (difference.empty()) continue;
      report.difference = fmt::format("{}: differs at macro step {}, iteration {}, {}",
                                      options.side, call.macro_step, call.iteration, difference);
      return;
    }
    report.macro_steps = journal->step.macro_step;
  }
}

/// Runs `use` with sides that are processes of their own, driven from here.
/// `connect(bus, monitor, options)` gives the side that they make.
template <class Connect, class Use>
void with_processes(const Model& model, const std::filesystem::path& folder,
                    const std::vector<Process>& sides, Connect connect, Use use) {
  const RunDirectory directory = RunDirectory::create_anew(folder);
  write_whole_file(directory.scenario(), model.scenario.resolved_yaml);
  wire::BusOptions options;
  options.self = Process::Orchestrator;
  options.run_id = wire::random_run_id();
  options.port = wire::free_port();
  options.names = process_names(model.table, model.world_table);
  wire::Bus bus(options);
  wire::Heartbeat heartbeat(bus, model.wire.timeout_s);
  heartbeat.set_phase("replaying");
  SideLaunch launch(sides, options.names, directory, options.run_id, options.port, false, false);
  try {
    wire::LivenessMonitor start(bus, sides, model.wire.start_timeout_s);
    while (!std::all_of(sides.begin(), sides.end(),
                        [&](Process side) { return start.heard_from(side); })) {
      start.wait(0.02);
      launch.supervise(sides);
    }
  } catch (const Error&) {
    launch.end_all(1.0);
    throw;
  }
  wire::LivenessMonitor monitor(bus, sides, model.wire.timeout_s);
  monitor.also_watch([&] { launch.supervise(sides); });
  auto remote = connect(bus, monitor,
                        wire::RemoteOptions{.scenario_hash = model.scenario.hash,
                                            .port_names = model.port_names,
                                            .tandem_version = kTandemVersion});
  use(*remote);
  monitor.also_watch({});
  remote->close();
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

/// The side of this name, among those that the model has.
Played played_side(const Model& model, const std::string& side) {
  if (side == "mbs") return {SideName::Mbs, model.port_names, std::nullopt};
  if (side == "fem") return {SideName::Fem, model.port_names, std::nullopt};
  std::vector<std::string> names{"mbs", "fem"};
  const auto find = [&](const std::vector<scenario::BodyPorts>& parts,
                        SideName kind) -> std::optional<Played> {
    for (const scenario::BodyPorts& part : parts) {
      if (part.name.empty()) continue;
      names.push_back(part.name);
      if (part.name != side) continue;
      if (parts.size() == 1) return Played{kind, model.port_names, std::nullopt};
      return Played{kind, of_ports(model.port_names, part.ports), part};
    }
    return std::nullopt;
  };
  if (const auto world = find(model.world_table, SideName::Mbs)) return *world;
  if (const auto body = find(model.table, SideName::Fem)) return *body;
  throw Error(ErrorKind::Usage,
              fmt::format("replay: --side {}: the run has no such side.{} It has {}.", side,
                          scenario::did_you_mean(side, names), fmt::join(names, ", ")));
}

/// The number of the played part; none: all of them.
std::optional<std::size_t> number_of(const Played& played,
                                     const std::vector<scenario::BodyPorts>& parts) {
  std::optional<std::size_t> number;
  for (std::size_t p = 0; played.part && p < parts.size(); ++p) {
    if (parts[p].name == played.part->name) number = p;
  }
  return number;
}

/// Their processes, or the one of this number.
std::vector<Process> those(std::vector<Process> processes, std::optional<std::size_t> only) {
  if (only) return {processes[*only]};
  return processes;
}

void replay_bodies(const Model& model, const Played& played, const ReplayOptions& options,
                   const std::filesystem::path& folder,
                   const std::function<void(FemSide&)>& check) {
  const std::optional<std::size_t> only = number_of(played, model.table);
  if (options.mode == Mode::Inproc) {
    return check(*(only ? make_fem(model, model.bodies[*only], {}) : make_fem(model, {})));
  }
  with_processes(
      model, folder, those(processes_of(model.table), only),
      [&](wire::Bus& bus, wire::LivenessMonitor& monitor, const wire::RemoteOptions& all) {
        return std::make_unique<RemoteBodies>(bus, monitor, model.table, all, only);
      },
      [&](RemoteBodies& remote) { check(remote.side()); });
}

void replay_worlds(const Model& model, const Played& played, const ReplayOptions& options,
                   const std::filesystem::path& folder,
                   const std::function<void(MbsSide&)>& check) {
  const std::optional<std::size_t> only = number_of(played, model.world_table);
  if (options.mode == Mode::Inproc) {
    return check(*(only ? make_mbs(model, model.worlds[*only], {}) : make_mbs(model, {})));
  }
  with_processes(
      model, folder, those(world_processes(model.world_table), only),
      [&](wire::Bus& bus, wire::LivenessMonitor& monitor, const wire::RemoteOptions& all) {
        return std::make_unique<RemoteWorlds>(bus, monitor, model.world_table, all, nullptr, only);
      },
      [&](RemoteWorlds& remote) { check(remote.side()); });
}

void replay_side(const RunDirectory& run, const ReplayOptions& options, wire::LogReader& log,
                 ReplayReport& report) {
  const Model model = load_model(run.scenario(), {{"wire.driver", "orchestrator"}});
  const Played played = played_side(model, options.side);
  const auto check = [&](auto& side) { replay_log(log, side, played, model, options, report); };
  const auto folder = run.path() / ("replay-" + options.side);
  if (played.side == SideName::Fem) return replay_bodies(model, played, options, folder, check);
  replay_worlds(model, played, options, folder, check);
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
