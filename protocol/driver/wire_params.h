#pragma once

#include <cstdint>

#include "protocol/driver/placement.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"
#include "protocol/wire/receiver.h"

namespace tandem {

/// Where the loop of the scheme runs in a run over LCM.
enum class DriverPlace {
  Mbs,           ///< in the multibody process: the sides exchange directly
  Orchestrator,  ///< in the orchestrator: every exchange passes through the hub
};

/// Section `wire`: how the processes of a run talk.
struct WireParams {
  DriverPlace driver = DriverPlace::Mbs;
  double timeout_s = 5.0;           ///< silence of a partner that ends the run
  double start_timeout_s = 20.0;    ///< for all processes to be ready
  std::int64_t credit_window = 64;  ///< macro steps the driver may be ahead of the recorder
  std::int64_t ttl = 0;             ///< of the multicast datagrams; 0 = this host only
  wire::Receive receive = wire::Receive::Own;
  wire::Wait wait = wire::Wait::Adaptive;
  Placement placement = Placement::Free;
};

[[nodiscard]] scenario::Key wire_keys();
[[nodiscard]] WireParams read_wire(const scenario::Node& root);

}  // namespace tandem
