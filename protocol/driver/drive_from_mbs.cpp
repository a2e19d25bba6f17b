#include <nlohmann/json.hpp>
#include <utility>

#include "protocol/driver/control_inbox.h"
#include "protocol/driver/coupled_run.h"
#include "protocol/driver/remote_bodies.h"
#include "protocol/driver/remote_worlds.h"
#include "protocol/driver/side_process.h"
#include "protocol/wire/handshake.h"
#include "protocol/wire/journal_sender.h"

namespace tandem {
namespace {

/// Journals to the orchestrator and keeps the heartbeat's macro step current.
class SendingSink final : public StepSink {
 public:
  SendingSink(wire::JournalSender& sender, SideContext& context)
      : sender_(sender), context_(context) {}

  double record(wire::StepJournal journal) override {
    context_.heartbeat.set_macro_step(journal.step.macro_step);
    context_.monitor.set_macro_step(journal.step.macro_step);
    return sender_.send(std::move(journal));
  }
  void rest(double seconds) override {
    // Looks, and sleeps: to wait for a datagram takes whole ticks of the kernel's clock.
    context_.monitor.wait(0.0);
    StepSink::rest(seconds);
  }

 private:
  wire::JournalSender& sender_;
  SideContext& context_;
};

}  // namespace

int drive_from_mbs(SideContext& context, std::unique_ptr<MbsSide> own) {
  const wire::HelloServer hello(context.bus, own->info(), context.scenario.hash, kTandemVersion);
  const wire::RemoteOptions expected{.scenario_hash = context.scenario.hash,
                                     .port_names = context.port_names,
                                     .tandem_version = kTandemVersion};
  context.heartbeat.set_phase("waiting for tandem-fem");
  RemoteBodies fem(context.bus, context.monitor, context.bodies, expected);
  if (context.worlds.size() > 1) context.heartbeat.set_phase("waiting for the other worlds");
  const Locality locality = context.worlds.size() > 1 ? Locality::Elsewhere : Locality::Here;
  RemoteWorlds mbs(context.bus, context.monitor, context.worlds, expected, std::move(own));
  context.heartbeat.set_phase("waiting for tandem");
  wire::await_hello(hello, context.monitor, context.wire.start_timeout_s);
  context.heartbeat.set_phase("stepping");
  const scenario::OutputParams output = scenario::read_output(context.scenario.root);
  wire::JournalSender sender(context.bus, context.monitor,
                             static_cast<int>(context.wire.credit_window),
                             output.log_every_steps == 1);
  SendingSink sink(sender, context);
  const CouplingParams coupling = read_coupling(context.scenario.root);
  ControlInbox inbox(context.bus);
  CoupledRunParams params = scheme_run(context.run, coupling);
  params.commands = &inbox;
  params.energy_every_steps = output.energy_every_steps;
  RunReport report =
      run_coupled(params, {mbs.side(), locality}, {fem.side(), Locality::Elsewhere}, sink);
  report.ledger.book_lost(context.bus.counts().damaged);
  context.heartbeat.set_phase("ending");
  fem.close();
  mbs.close();
  sender.finish({.exit_code = report.exit_code(),
                 .message = report.message,
                 .summary_json = to_json(report).dump()});
  return report.exit_code();
}

}  // namespace tandem
