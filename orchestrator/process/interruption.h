#pragma once

#include <array>
#include <csignal>

namespace tandem::orchestrator {

/// The signal that asked this process to stop, 0 = none. Stays set: what follows stops as well.
[[nodiscard]] int stop_signal();

/// Throws a System error "interrupted by SIGINT (Interrupt)" once a signal has asked to stop.
void throw_if_interrupted();

/// While it lives, the first SIGINT, SIGTERM or SIGHUP only sets stop_signal(), so that the run can
/// end in order; the second one ends the process at once. A closed terminal or pipe (SIGPIPE) does
/// not end a run either: its results are files. Signals that were ignored stay ignored (nohup).
class InterruptionGuard {
 public:
  InterruptionGuard();
  ~InterruptionGuard();
  InterruptionGuard(const InterruptionGuard&) = delete;
  InterruptionGuard& operator=(const InterruptionGuard&) = delete;

 private:
  static constexpr std::array<int, 4> kSignals{SIGINT, SIGTERM, SIGHUP, SIGPIPE};
  std::array<struct sigaction, kSignals.size()> before_{};
};

}  // namespace tandem::orchestrator
