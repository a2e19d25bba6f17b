#include "orchestrator/process/interruption.h"

#include <fmt/format.h>

#include <atomic>
#include <cstddef>
#include <cstring>

#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

// A signal handler can reach nothing but a global.
std::atomic<int> received{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler writes it");

void remember(int signal) { received = signal; }

std::string name_of(int signal) {
  return fmt::format("SIG{} ({})", sigabbrev_np(signal), strsignal(signal));
}

}  // namespace

int stop_signal() { return received; }

void throw_if_interrupted() {
  const int signal = received;
  if (signal != 0) {
    throw Error(ErrorKind::System, fmt::format("interrupted by {}.", name_of(signal)));
  }
}

InterruptionGuard::InterruptionGuard() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    if (before_[i].sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    sigemptyset(&action.sa_mask);
    action.sa_handler = kSignals[i] == SIGPIPE ? SIG_IGN : remember;
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigaction(kSignals[i], &action, nullptr);
  }
}

InterruptionGuard::~InterruptionGuard() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

}  // namespace tandem::orchestrator
