#include "protocol/driver/remote_bodies.h"

#include <fmt/format.h>

#include <utility>

#include "protocol/contract/error.h"
#include "protocol/driver/composite_side.h"

namespace tandem {

std::vector<wire::Process> processes_of(const std::vector<scenario::BodyPorts>& bodies) {
  std::vector<wire::Process> processes;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    processes.push_back(wire::body_process(b, bodies.size()));
  }
  return processes;
}

wire::ProcessNames process_names(const std::vector<scenario::BodyPorts>& bodies,
                                 const std::vector<scenario::BodyPorts>& worlds) {
  require(
      bodies.size() <= wire::kMostBodies && worlds.size() <= wire::kMostWorlds,
      fmt::format("wire: {} flexible bodies and {} multibody worlds; a run over LCM holds {} and "
                  "{} at most. Use --transport inproc.",
                  bodies.size(), worlds.size(), wire::kMostBodies, wire::kMostWorlds));
  const auto names_of = [](const std::vector<scenario::BodyPorts>& parts) {
    std::vector<std::string> names;
    if (parts.size() == 1) return names;
    for (const scenario::BodyPorts& part : parts) names.push_back(part.name);
    return names;
  };
  return wire::ProcessNames(names_of(bodies), names_of(worlds));
}

wire::RemoteOptions options_of(const std::vector<scenario::BodyPorts>& bodies, std::size_t b,
                               const wire::RemoteOptions& all) {
  wire::RemoteOptions own = all;
  own.side = wire::body_process(b, bodies.size());
  own.port_names = of_ports(all.port_names, bodies[b].ports);
  return own;
}

RemoteBodies::RemoteBodies(wire::Bus& bus, wire::LivenessMonitor& monitor,
                           const std::vector<scenario::BodyPorts>& bodies,
                           const wire::RemoteOptions& all, std::optional<std::size_t> only)
    : monitor_(monitor) {
  std::vector<FemPart> parts;
  if (bodies.size() > 1 && !only) together_ = std::make_unique<wire::RemoteLinks>(bus, monitor);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (only.value_or(b) != b) continue;
    processes_.push_back(wire::body_process(b, bodies.size()));
    auto link = std::make_unique<wire::RemoteFem>(bus, monitor, options_of(bodies, b, all),
                                                  together_.get());
    links_.push_back(link.get());
    parts.push_back({bodies[b].name, std::move(link), bodies[b].ports});
  }
  side_ = composed(std::move(parts));
}

void RemoteBodies::close() {
  for (std::size_t b = 0; b < links_.size(); ++b) {
    links_[b]->close();
    monitor_.release(processes_[b]);
  }
}

}  // namespace tandem
