#include "protocol/driver/remote_worlds.h"

#include <utility>

#include "protocol/driver/composite_side.h"

namespace tandem {

std::vector<wire::Process> world_processes(const std::vector<scenario::BodyPorts>& worlds) {
  std::vector<wire::Process> processes;
  for (std::size_t w = 0; w < worlds.size(); ++w) {
    processes.push_back(wire::world_process(w, worlds.size()));
  }
  return processes;
}

wire::Process driver_process(DriverPlace place, const std::vector<scenario::BodyPorts>& worlds) {
  return place == DriverPlace::Mbs ? wire::world_process(0, worlds.size())
                                   : wire::Process::Orchestrator;
}

wire::RemoteOptions options_of_world(const std::vector<scenario::BodyPorts>& worlds, std::size_t w,
                                     const wire::RemoteOptions& all) {
  wire::RemoteOptions own = all;
  own.side = wire::world_process(w, worlds.size());
  own.port_names = of_ports(all.port_names, worlds[w].ports);
  return own;
}

RemoteWorlds::RemoteWorlds(wire::Bus& bus, wire::LivenessMonitor& monitor,
                           const std::vector<scenario::BodyPorts>& worlds,
                           const wire::RemoteOptions& all, std::unique_ptr<MbsSide> first,
                           std::optional<std::size_t> only)
    : monitor_(monitor) {
  std::vector<MbsPart> parts;
  if (first) parts.push_back({worlds[0].name, std::move(first), worlds[0].ports});
  for (std::size_t w = parts.size(); w < worlds.size(); ++w) {
    if (only.value_or(w) != w) continue;
    processes_.push_back(wire::world_process(w, worlds.size()));
    auto link = std::make_unique<wire::RemoteMbs>(bus, monitor, options_of_world(worlds, w, all));
    links_.push_back(link.get());
    parts.push_back({worlds[w].name, std::move(link), worlds[w].ports});
  }
  side_ = composed(std::move(parts));
}

void RemoteWorlds::close() {
  for (std::size_t w = 0; w < links_.size(); ++w) {
    links_[w]->close();
    monitor_.release(processes_[w]);
  }
}

}  // namespace tandem
