#include "protocol/driver/wire_params.h"

#include <fmt/format.h>

#include <string>
#include <utility>

namespace tandem {

scenario::Key wire_keys() {
  using scenario::choice;
  using scenario::integer;
  using scenario::real;
  const WireParams d;
  scenario::Section content{
      "Wire",
      "How the processes of a run over LCM talk to each other.",
      {choice("driver", {"mbs", "orchestrator"})
           .doc_is("Process that runs the scheme: mbs lets the two sides exchange directly, "
                   "orchestrator makes every exchange pass through the hub.")
           .by_default("mbs"),
       real("timeout_s", "s")
           .doc_is("Silence of a partner process after which the run ends with exit code 4.")
           .between(0.5, 3600.0)
           .by_default(fmt::format("{}", d.timeout_s)),
       real("start_timeout_s", "s")
           .doc_is("Time for all processes to start and to be ready.")
           .between(0.5, 3600.0)
           .by_default(fmt::format("{}", d.start_timeout_s)),
       integer("credit_window")
           .doc_is("Macro steps that the driver may be ahead of what is recorded on disk.")
           .between(1, 100000)
           .by_default(std::to_string(d.credit_window)),
       integer("ttl")
           .doc_is(
               "Time to live of the multicast datagrams: 0 keeps them on this host, 1 lets them "
               "reach other hosts of the subnet.")
           .between(0, 255)
           .by_default(std::to_string(d.ttl)),
       choice("receive", {"own", "lcm"})
           .doc_is("How a process listens: own reads LCM's datagrams in the thread that waits for "
                   "them, lcm goes through liblcm's receive thread. The same bits, more time.")
           .by_default("own"),
       choice("wait", {"adaptive", "block", "poll"})
           .doc_is("How the sides wait for each other: block sleeps until a message comes and pays "
                   "for being woken, poll looks again and again and keeps a core busy, adaptive "
                   "polls for short waits where a core is free for it. The same bits.")
           .by_default("adaptive"),
       choice("placement", {"free", "same", "cross"})
           .doc_is("Cores of the two sides, which compute in turn: free leaves them to the kernel, "
                   "same binds both to one core (the cheapest exchange; for sides of one thread), "
                   "cross each to a core of its own.")
           .by_default("free")}};
  return scenario::section("wire", std::move(content)).by_default("{}");
}

namespace {

Placement placement_of(const std::string& name) {
  if (name == "same") return Placement::Same;
  return name == "cross" ? Placement::Cross : Placement::Free;
}

wire::Wait wait_of(const std::string& name) {
  if (name == "block") return wire::Wait::Block;
  return name == "poll" ? wire::Wait::Poll : wire::Wait::Adaptive;
}

}  // namespace

WireParams read_wire(const scenario::Node& root) {
  const scenario::Node node = root.section("wire");
  return WireParams{
      .driver = node.text("driver") == "mbs" ? DriverPlace::Mbs : DriverPlace::Orchestrator,
      .timeout_s = node.real("timeout_s"),
      .start_timeout_s = node.real("start_timeout_s"),
      .credit_window = node.integer("credit_window"),
      .ttl = node.integer("ttl"),
      .receive = node.text("receive") == "lcm" ? wire::Receive::Lcm : wire::Receive::Own,
      .wait = wait_of(node.text("wait")),
      .placement = placement_of(node.text("placement")),
  };
}

}  // namespace tandem
