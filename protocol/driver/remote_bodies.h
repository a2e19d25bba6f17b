#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/scenario/flexible_bodies.h"
#include "protocol/wire/remote_side.h"

namespace tandem {

/// The processes of a run's flexible bodies, in their order.
[[nodiscard]] std::vector<wire::Process> processes_of(
    const std::vector<scenario::BodyPorts>& bodies);

/// The names of the flexible bodies and of the multibody worlds, for the bus; none of a kind of
/// which there is one. Throws a Usage error where there are more than a run over LCM holds.
[[nodiscard]] wire::ProcessNames process_names(const std::vector<scenario::BodyPorts>& bodies,
                                               const std::vector<scenario::BodyPorts>& worlds);

/// What the process of body `b` is to be: `all` says it of the whole flexible side.
[[nodiscard]] wire::RemoteOptions options_of(const std::vector<scenario::BodyPorts>& bodies,
                                             std::size_t b, const wire::RemoteOptions& all);

/// The flexible side of a run over LCM: the process of the one body, or those of several as one
/// side, which compute at the same time.
class RemoteBodies {
 public:
  /// Connects to all, or to the one of this number; see wire::RemoteLink::connect().
  RemoteBodies(wire::Bus& bus, wire::LivenessMonitor& monitor,
               const std::vector<scenario::BodyPorts>& bodies, const wire::RemoteOptions& all,
               std::optional<std::size_t> only = std::nullopt);

  [[nodiscard]] FemSide& side() { return *side_; }

  /// Ends the processes; they are not watched any more.
  void close();

 private:
  wire::LivenessMonitor& monitor_;
  std::unique_ptr<wire::RemoteLinks> together_;  ///< of several
  std::vector<wire::Process> processes_;
  std::vector<wire::RemoteFem*> links_;  ///< owned by side_
  std::unique_ptr<FemSide> side_;
};

}  // namespace tandem
