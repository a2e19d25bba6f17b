#include "protocol/driver/placement.h"

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <vector>

#include "protocol/contract/error.h"

namespace tandem {
namespace {

std::vector<std::size_t> usable_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<std::size_t> cores;
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return cores;
  for (std::size_t core = 0; core < CPU_SETSIZE; ++core) {
    if (CPU_ISSET(core, &set)) cores.push_back(core);
  }
  return cores;
}

void bind_to(const std::vector<std::size_t>& cores) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const std::size_t core : cores) CPU_SET(core, &set);
  sched_setaffinity(0, sizeof(set), &set);  // a refusal leaves the process free: slower, not wrong
}

/// Of this process: the others go first where they share a core with it.
void lower_priority() {
  const int policy = sched_getscheduler(0);
  if (policy == SCHED_FIFO || policy == SCHED_RR) {
    sched_param param{};
    sched_getparam(0, &param);
    param.sched_priority = std::max(1, param.sched_priority - 1);
    sched_setscheduler(0, policy, &param);
  } else {
    setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + 5);
  }
}

}  // namespace

wire::Wait wait_in_run(wire::Wait asked, Placement placement, wire::Process self,
                       wire::Process driver, std::size_t bodies) {
  const bool records = self == wire::Process::Orchestrator && self != driver;
  const bool alone = placement != Placement::Same && usable_cores().size() > bodies;
  return records || !alone ? wire::Wait::Block : asked;
}

void place_process(Placement placement, wire::Process self, wire::Process driver,
                   std::uint64_t run_id) {
  if (placement == Placement::Free) return;
  const std::vector<std::size_t> cores = usable_cores();
  require(placement == Placement::Same || cores.size() > 1,
          "wire.placement: cross needs two cores; this process may use one. Choose same or free.");
  if (cores.empty()) return;
  const std::size_t first = run_id % cores.size();
  const std::size_t second = (first + (placement == Placement::Cross ? 1 : 0)) % cores.size();
  if (self == driver) return bind_to({cores[first]});
  if (self != wire::Process::Orchestrator) return bind_to({cores[second]});
  std::vector<std::size_t> others;
  std::copy_if(cores.begin(), cores.end(), std::back_inserter(others),
               [&](std::size_t core) { return core != cores[first] && core != cores[second]; });
  if (others.empty()) return lower_priority();
  bind_to(others);
}

}  // namespace tandem
