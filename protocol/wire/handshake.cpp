#include "protocol/wire/handshake.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::wire {
namespace {

constexpr double kHelloPeriod_s = 0.05;

void check(const Bus& bus, const Handshake& welcome, const RemoteOptions& options) {
  require(welcome.refusal.empty(),
          fmt::format("{}: {} refuses the run: {}", bus.name_of(options.side),
                      bus.program_of(options.side), welcome.refusal));
  const std::size_t here = options.port_names.size();
  const std::size_t there = welcome.ports.size();
  for (std::size_t i = 0; i < std::max(here, there); ++i) {
    const std::string name_here = i < here ? options.port_names[i] : "none";
    const std::string name_there = i < there ? welcome.ports[i].name : "none";
    require(name_here == name_there,
            fmt::format("{}: port {} is '{}' there, but '{}' here", bus.name_of(options.side),
                        i + 1, name_there, name_here));
  }
}

Error silent(const Bus& bus, Process process, double timeout_s, const char* what) {
  return {ErrorKind::Partner,
          fmt::format("{}: {} lives, but has not {} within {:.3g} s: it is of another version. "
                      "Install both from one build.",
                      bus.name_of(bus.options().self), bus.program_of(process), what, timeout_s)};
}

}  // namespace

Handshake greet(Bus& bus, LivenessMonitor& monitor, const RemoteOptions& options,
                double timeout_s) {
  std::optional<Handshake> welcome;
  bool other_schema = false;
  const Subscription subscription =
      bus.subscribe(options.side, Kind::Welcome, [&](const Header&, ByteView message) {
        welcome = decode_handshake(message);
        other_schema = !welcome.has_value();
      });
  Handshake hello;
  hello.tandem_version = options.tandem_version;
  hello.scenario_hash = options.scenario_hash;
  hello.receive_buffer_bytes = bus.receive_buffer_bytes();
  hello.process_id = static_cast<std::int32_t>(getpid());
  for (const std::string& name : options.port_names)
    hello.ports.push_back({.name = name, .length_m = 0.0, .body = 0});
  const double end_s = now_s() + timeout_s;
  double send_s = 0.0;
  // Messages are not kept for late subscribers: say hello until the side is up and answers.
  for (std::int64_t n = 1; !welcome && !other_schema;) {
    const double time_s = now_s();
    if (time_s > end_s) {
      throw silent(bus, options.side, timeout_s, "answered a hello");
    }
    if (time_s >= send_s) {
      hello.header = bus.header(Kind::Hello, n++);
      Bytes message = encode(hello);
      bus.publish(options.side, Kind::Hello, message);
      send_s = now_s() + kHelloPeriod_s;
    }
    monitor.wait(kHelloPeriod_s);
  }
  require(!other_schema,
          fmt::format("{}: {} speaks another message schema than this {}. Install both from one "
                      "build.",
                      bus.name_of(options.side), bus.program_of(options.side),
                      bus.program_of(bus.options().self)));
  check(bus, *welcome, options);
  return *welcome;
}

HelloServer::HelloServer(Bus& bus, const SubsystemInfo& info, std::uint64_t scenario_hash,
                         std::string tandem_version)
    : bus_(bus),
      info_(info),
      scenario_hash_(scenario_hash),
      tandem_version_(std::move(tandem_version)) {
  hellos_ = bus_.subscribe(bus_.options().self, Kind::Hello,
                           [this](const Header&, ByteView message) { on_hello(message); });
}

std::string HelloServer::mismatch(const Handshake& hello) const {
  if (hello.protocol_version != kProtocolVersion) {
    return fmt::format("protocol version {} there, {} here. Install both from one build.",
                       hello.protocol_version, kProtocolVersion);
  }
  if (hello.tandem_version != tandem_version_) {
    return fmt::format("Tandem {} there, {} here. Install both from one build.",
                       hello.tandem_version, tandem_version_);
  }
  if (hello.scenario_hash != scenario_hash_) {
    return fmt::format("scenario hash {:016x} there, {:016x} here. Give both the same file.",
                       hello.scenario_hash, scenario_hash_);
  }
  const auto same_name = [](const PortInfo& a, const PortInfo& b) { return a.name == b.name; };
  if (!std::equal(hello.ports.begin(), hello.ports.end(), info_.ports.begin(), info_.ports.end(),
                  same_name)) {
    const auto list = [](const std::vector<PortInfo>& ports) {
      std::string names;
      for (const PortInfo& port : ports) names += (names.empty() ? "" : ", ") + port.name;
      return names;
    };
    return fmt::format("ports [{}] there, [{}] here. Give both the same file.", list(hello.ports),
                       list(info_.ports));
  }
  return {};
}

void HelloServer::on_hello(ByteView message) {
  Handshake welcome;
  if (const auto hello = decode_handshake(message)) {
    welcome.refusal = mismatch(*hello);
  } else {
    welcome.refusal = "another message schema. Install both from one build.";
  }
  welcome.header = bus_.header(Kind::Welcome, 1);
  welcome.tandem_version = tandem_version_;
  welcome.scenario_hash = scenario_hash_;
  welcome.ports = info_.ports;
  welcome.micro_step = info_.micro_step;
  welcome.can_linearize = info_.can_linearize;
  welcome.receive_buffer_bytes = bus_.receive_buffer_bytes();
  welcome.process_id = static_cast<std::int32_t>(getpid());
  Bytes bytes = encode(welcome);
  bus_.publish(bus_.options().self, Kind::Welcome, bytes);
  if (welcome.refusal.empty()) {
    greeted_ = true;
  } else if (refusal_.empty()) {
    refusal_ = welcome.refusal;
  }
}

void await_hello(const HelloServer& server, LivenessMonitor& monitor, double timeout_s) {
  const double end_s = now_s() + timeout_s;
  while (!server.greeted() && server.refusal().empty()) {
    if (now_s() > end_s) throw silent(server.bus(), Process::Orchestrator, timeout_s, "said hello");
    monitor.wait(kHelloPeriod_s);
  }
  if (!server.refusal().empty()) {
    throw Error(ErrorKind::Usage,
                fmt::format("mbs: tandem (the orchestrator) does not fit: {}", server.refusal()));
  }
}

}  // namespace tandem::wire
