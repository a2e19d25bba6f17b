#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/driver/wire_params.h"
#include "protocol/scenario/multibody_worlds.h"
#include "protocol/wire/remote_side.h"

namespace tandem {

/// The processes of a run's multibody worlds, in their order.
[[nodiscard]] std::vector<wire::Process> world_processes(
    const std::vector<scenario::BodyPorts>& worlds);

/// The process that runs the scheme: of several worlds the first one's.
[[nodiscard]] wire::Process driver_process(DriverPlace place,
                                           const std::vector<scenario::BodyPorts>& worlds);

/// What the process of world `w` is to be: `all` says it of the whole multibody side.
[[nodiscard]] wire::RemoteOptions options_of_world(const std::vector<scenario::BodyPorts>& worlds,
                                                   std::size_t w, const wire::RemoteOptions& all);

/// The multibody side of a run over LCM, as RemoteBodies is the flexible one: the process of the
/// one world, or those of several as one side, which compute at the same time.
class RemoteWorlds {
 public:
  /// Connects to all, or to the one of this number; see wire::RemoteLink::connect(). With `first`,
  /// the first world is that object of this process.
  RemoteWorlds(wire::Bus& bus, wire::LivenessMonitor& monitor,
               const std::vector<scenario::BodyPorts>& worlds, const wire::RemoteOptions& all,
               std::unique_ptr<MbsSide> first = nullptr,
               std::optional<std::size_t> only = std::nullopt);

  [[nodiscard]] MbsSide& side() { return *side_; }

  /// Ends the processes; they are not watched any more.
  void close();

 private:
  wire::LivenessMonitor& monitor_;
  std::vector<wire::Process> processes_;
  std::vector<wire::RemoteMbs*> links_;  ///< owned by side_
  std::unique_ptr<MbsSide> side_;
};

}  // namespace tandem
