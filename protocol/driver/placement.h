#pragma once

#include <cstddef>
#include <cstdint>

#include "protocol/wire/poll_budget.h"
#include "protocol/wire/seal.h"

namespace tandem {

/// Cores of the two sides, which compute in turn.
enum class Placement {
  Free,   ///< as the kernel decides
  Same,   ///< both on one core: no wake-up of another core in an exchange
  Cross,  ///< each on a core of its own
};

/// Binds the calling process, and the threads that it will start, to its cores of the run, out of
/// those that it may use now. The processes that alternate are the driver and the sides it calls:
///   same    all of them on one core; an orchestrator that only records on the others
///   cross   the driver on one core, the sides it calls on another
/// An orchestrator that only records and finds no other core takes what they leave: lower priority.
/// `run_id` picks the cores, so that runs at the same time spread. Throws tandem::Error (Usage)
/// when Cross finds one core only.
void place_process(Placement placement, wire::Process self, wire::Process driver,
                   std::uint64_t run_id);

/// How a process of the run waits for messages: as `asked`, but blocking
/// * in an orchestrator that only records: nobody waits for it;
/// * with Same, or where the sides (the multibody one and so many flexible bodies) are more than
///   the cores they may use: polling would keep a core from one that computes.
/// To be asked before place_process().
[[nodiscard]] wire::Wait wait_in_run(wire::Wait asked, Placement placement, wire::Process self,
                                     wire::Process driver, std::size_t bodies = 1);

}  // namespace tandem
