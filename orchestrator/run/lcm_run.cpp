#include "orchestrator/run/lcm_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "orchestrator/process/interruption.h"
#include "orchestrator/process/side_launch.h"
#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"
#include "protocol/driver/control_inbox.h"
#include "protocol/driver/remote_bodies.h"
#include "protocol/driver/remote_worlds.h"
#include "protocol/driver/side_process.h"
#include "protocol/wire/journal_receiver.h"

namespace tandem::orchestrator {
namespace {

using wire::Process;

wire::BusOptions bus_options(const Model& model, std::uint64_t run_id) {
  const WireParams& params = model.wire;
  wire::BusOptions options;
  options.names = process_names(model.table, model.world_table);
  options.self = Process::Orchestrator;
  options.run_id = run_id;
  options.port = wire::free_port();
  options.ttl = static_cast<int>(params.ttl);
  options.receive = params.receive;
  const Process driver = driver_process(params.driver, model.world_table);
  options.wait = wait_in_run(params.wait, params.placement, options.self, driver,
                             model.table.size() + model.world_table.size() - 1);
  return options;
}

/// The processes that this one starts: the multibody worlds and the flexible bodies.
std::vector<Process> sides_of(const Model& model) {
  std::vector<Process> sides = world_processes(model.world_table);
  for (const Process body : processes_of(model.table)) sides.push_back(body);
  return sides;
}

/// Passes journals on to the recorder and keeps the heartbeat's macro step current (hub).
class HubSink final : public StepSink {
 public:
  HubSink(Recorder& recorder, wire::Heartbeat& heartbeat, wire::LivenessMonitor& monitor,
          SideLaunch& launch, const std::vector<Process>& sides)
      : recorder_(recorder),
        heartbeat_(heartbeat),
        monitor_(monitor),
        launch_(launch),
        sides_(sides) {}
  double record(wire::StepJournal journal) override {
    heartbeat_.set_macro_step(journal.step.macro_step);
    monitor_.set_macro_step(journal.step.macro_step);
    // Each supervision is two system calls a process: often enough for a person, and cheap.
    if (journal.step.macro_step % 64 == 0) launch_.supervise(sides_);
    return recorder_.record(std::move(journal));
  }
  void rest(double seconds) override {
    // Looks, and sleeps: to wait for a datagram takes whole ticks of the kernel's clock.
    monitor_.wait(0.0);
    recorder_.rest(seconds);
  }

 private:
  Recorder& recorder_;
  wire::Heartbeat& heartbeat_;
  wire::LivenessMonitor& monitor_;
  SideLaunch& launch_;
  const std::vector<Process>& sides_;
};

class LcmRun {
 public:
  LcmRun(const Model& model, const RunDirectory& directory, const RunOptions& options,
         std::uint64_t run_id, Recorder& recorder)
      : model_(model),
        silent_(options.silent),
        recorder_(recorder),
        driver_(driver_process(model.wire.driver, model.world_table)),
        sides_(sides_of(model)),
        bus_(bus_options(model, run_id)),
        heartbeat_(bus_, model.wire.timeout_s),
        launch_(sides_, bus_.options().names, directory, run_id, bus_.options().port,
                options.attach, options.silent) {
    warn_of_buffer(model.port_names.size());
    const nlohmann::ordered_json address = {{"run_id", fmt::format("{:016x}", run_id)},
                                            {"port", bus_.options().port},
                                            {"ttl", bus_.options().ttl}};
    // Whoever knows the run id can command the run.
    write_whole_file(directory.bus(), address.dump() + "\n", Readers::Owner);
  }

  wire::Finished run() {
    try {
      await_sides();
      wire::LivenessMonitor monitor(bus_, sides_, model_.wire.timeout_s);
      wire::Finished finished =
          model_.wire.driver == DriverPlace::Mbs ? record_from_mbs(monitor) : drive_here(monitor);
      const std::vector<std::string> failures = launch_.end_all(model_.wire.timeout_s);
      // A run that is not solved ends its driver with 3: that is the run's own outcome.
      if (finished.exit_code == 0 && !failures.empty()) {
        throw Error(ErrorKind::Partner, fmt::format("{}", fmt::join(failures, "; ")));
      }
      return finished;
    } catch (const Error& error) {
      throw Error(error.kind(), explain(error));
    }
  }

 private:
  /// A step of two calls that a small receive buffer cannot hold is sent in several goes.
  void warn_of_buffer(std::size_t ports) const {
    constexpr std::size_t kBytesPerPort = 2 * 48 + 104 + 2 * 104 + 48;
    const int granted = bus_.receive_buffer_bytes();
    if (silent_ || granted <= 0 || granted >= 2 * bus_.options().receive_buffer_bytes) return;
    if (ports * kBytesPerPort < wire::unrecorded_bytes(granted)) return;
    std::fprintf(stderr,
                 "note: the kernel grants a receive buffer of %d KiB, less than the %zu KiB of a "
                 "macro step of %zu ports: messages take several round trips. As root: sysctl -w "
                 "net.core.rmem_max=%d\n",
                 granted / 1024, ports * kBytesPerPort / 1024, ports,
                 bus_.options().receive_buffer_bytes);
  }

  /// Until both processes have been heard; says who is waiting for whom when it takes long.
  void await_sides() {
    heartbeat_.set_phase(sides_.size() == 2 ? "waiting for both sides" : "waiting for all sides");
    wire::LivenessMonitor monitor(bus_, sides_, model_.wire.start_timeout_s);
    std::string shown;
    double next_s = now_s() + 1.0;
    while (!std::all_of(sides_.begin(), sides_.end(),
                        [&](Process side) { return monitor.heard_from(side); })) {
      monitor.wait(0.02);
      launch_.supervise(sides_);
      if (silent_ || now_s() < next_s) continue;
      next_s = now_s() + 1.0;
      const std::string text = "waiting: " + phases(monitor);
      if (text != shown) std::fprintf(stderr, "%s\n", text.c_str());
      shown = text;
    }
    heartbeat_.set_phase("recording");
  }

  /// "tandem-mbs is loading its model, tandem-fem is not heard yet".
  [[nodiscard]] std::string phases(const wire::LivenessMonitor& monitor) const {
    std::vector<std::string> texts;
    for (const Process side : sides_) {
      const std::string& phase = monitor.phase(side);
      texts.push_back(bus_.program_of(side) + " is " + (phase.empty() ? "not heard yet" : phase));
    }
    return fmt::format("{}", fmt::join(texts, ", "));
  }

  wire::Finished record_from_mbs(wire::LivenessMonitor& monitor) {
    wire::JournalReceiver receiver(bus_, monitor, static_cast<int>(model_.wire.credit_window));
    monitor.also_watch([this] { launch_.supervise({driver_}); });
    (void)wire::greet(bus_, monitor, options_of_world(model_.world_table, 0, expected()),
                      model_.wire.start_timeout_s);
    monitor.also_watch({});
    std::optional<wire::Finished> finished;
    double patience_end_s = 0.0;
    // The driver leaves once it knows that its last entry is recorded; the credit that says so may
    // be lost, so go on listening until its process has ended, or is frozen.
    while (!finished || (!driver_left() && now_s() < patience_end_s)) {
      auto entry = receiver.next(0.02);
      supervise(monitor, finished.has_value());
      if (!entry) continue;
      if (auto* journal = std::get_if<wire::StepJournal>(&*entry)) {
        heartbeat_.set_macro_step(journal->step.macro_step);
        monitor.set_macro_step(journal->step.macro_step);
        recorder_.record(std::move(*journal));
      } else {
        finished = std::get<wire::Finished>(*entry);
        patience_end_s = now_s() + model_.wire.timeout_s;
        for (const Process side : sides_) monitor.release(side);
      }
      receiver.recorded();
    }
    return *finished;
  }

  [[nodiscard]] wire::RemoteOptions expected() const {
    return {.scenario_hash = model_.scenario.hash,
            .port_names = model_.port_names,
            .tandem_version = kTandemVersion};
  }

  bool driver_left() {
    // Sides started by hand are not ours to wait for: they linger long enough for the last credit.
    return launch_.started(driver_) ? launch_.ended(driver_).has_value() : true;
  }

  void supervise(wire::LivenessMonitor& monitor, bool finished) {
    if (now_s() < next_supervision_s_) return;
    next_supervision_s_ = now_s() + 0.02;
    if (finished) return;
    for (const Process side : sides_) {
      if (side == driver_) continue;
      const auto status = launch_.ended(side);
      // It was told bye; the driver is about to finish.
      if (status && status->code == 0) monitor.release(side);
    }
    launch_.supervise({driver_});
  }

  wire::Finished drive_here(wire::LivenessMonitor& monitor) {
    monitor.also_watch([this] { launch_.supervise(sides_); });
    RemoteWorlds mbs(bus_, monitor, model_.world_table, expected());
    RemoteBodies fem(bus_, monitor, model_.table, expected());
    HubSink sink(recorder_, heartbeat_, monitor, launch_, sides_);
    ControlInbox inbox(bus_);
    CoupledRunParams params = scheme_run(model_.run, model_.coupling);
    params.commands = &inbox;
    params.energy_every_steps = scenario::read_output(model_.scenario.root).energy_every_steps;
    RunReport report = run_coupled(params, {mbs.side(), Locality::Elsewhere},
                                   {fem.side(), Locality::Elsewhere}, sink);
    report.ledger.book_lost(bus_.counts().damaged);
    monitor.also_watch({});
    fem.close();
    mbs.close();
    return {.exit_code = report.exit_code(),
            .message = report.message,
            .summary_json = to_json(report).dump()};
  }

  /// The error together with what became of the processes; ends them all.
  std::string explain(const Error& error) {
    recorder_.end_progress();
    // A failing process says why before it goes: prefer its own words to "it ended".
    std::string text = error.what();
    for (int i = 0; i < 20 && stop_signal() == 0; ++i) {
      try {
        wire::LivenessMonitor(bus_, sides_, 3600.0).wait(0.01);
      } catch (const Error& said) {
        text = said.what();
        break;
      }
    }
    std::vector<std::string> fates = launch_.left_in_peace();
    const int signal = stop_signal();
    wire::publish_abort(bus_, signal != 0 ? 128 + signal : error.exit_code(), text);
    for (std::string& fate : launch_.end_all(1.0)) fates.push_back(std::move(fate));
    if (!text.ends_with('.')) text += '.';
    if (recorder_.recorded_steps() > 0) {
      text += fmt::format(" The log is complete up to macro step {}.", recorder_.recorded_steps());
    }
    if (stop_signal() != 0) return text;  // the sides ended because they were told to
    for (const std::string& fate : fates) text += "\n  " + fate;
    return text;
  }

  const Model& model_;
  bool silent_;
  Recorder& recorder_;
  Process driver_;
  std::vector<Process> sides_;
  wire::Bus bus_;
  wire::Heartbeat heartbeat_;
  SideLaunch launch_;
  double next_supervision_s_ = 0.0;
};

}  // namespace

wire::Finished run_over_lcm(const Model& model, const RunDirectory& directory,
                            const RunOptions& options, std::uint64_t run_id, Recorder& recorder) {
  return LcmRun(model, directory, options, run_id, recorder).run();
}

}  // namespace tandem::orchestrator
