#include "fem_process/kernels/thread_team.h"

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace tandem::fem {
namespace {

/// Looks that a waiting thread takes before it yields or sleeps: some 30 µs.
constexpr int kLooks = 2000;

void pause_a_little() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// The gate of a loop: helpers inside, whether it is open, and the loop's number.
using Gate = std::uint32_t;
constexpr Gate kInside = 0xff;
constexpr Gate kOpen = 0x100;
constexpr Gate kNext = 0x200;

}  // namespace

struct ThreadTeam::Helpers {
  /// One thread's share of the parts: [next, end).
  struct alignas(64) Share {
    std::atomic<int> next{0};
    int end = 0;
  };

  explicit Helpers(int threads) : shares(static_cast<std::size_t>(threads)) {
    for (int t = 1; t < threads; ++t) pool.emplace_back([this, t] { serve(t); });
  }
  ~Helpers() {
    quit.store(true);
    gate.fetch_add(kNext | kOpen, std::memory_order_release);
    gate.notify_all();
    for (std::thread& helper : pool) helper.join();
  }
  Helpers(const Helpers&) = delete;
  Helpers& operator=(const Helpers&) = delete;

  /// Own share first, then what others have left.
  void work_on(std::size_t self) {
    for (std::size_t k = 0; k < shares.size(); ++k) {
      Share& from = shares[(self + k) % shares.size()];
      for (int part = from.next.fetch_add(1, std::memory_order_relaxed); part < from.end;
           part = from.next.fetch_add(1, std::memory_order_relaxed)) {
        call(work, part);
      }
    }
  }

  /// Goes through every gate that it finds open. A helper that comes late finds the gate closed and
  /// nobody has waited for it.
  void serve(int self) {
    Gate done = 0;
    for (int look = 0;;) {
      Gate now = gate.load(std::memory_order_acquire);
      if ((now & kOpen) == 0 || (now & ~kInside) == done) {
        if (++look < kLooks) {
          pause_a_little();
        } else if ((now & kOpen) == 0) {
          gate.wait(now, std::memory_order_acquire);
          look = 0;
        } else {
          std::this_thread::yield();
        }
        continue;
      }
      if (quit.load()) return;
      if (!gate.compare_exchange_weak(now, now + 1, std::memory_order_acq_rel)) continue;
      work_on(static_cast<std::size_t>(self));
      done = now & ~kInside;
      gate.fetch_sub(1, std::memory_order_release);
      look = 0;
    }
  }

  std::vector<Share> shares;
  Call call = nullptr;
  const void* work = nullptr;
  alignas(64) std::atomic<Gate> gate{0};
  alignas(64) std::atomic<bool> quit{false};
  std::vector<std::thread> pool;
};

ThreadTeam::ThreadTeam(int threads)
    : helpers_(threads > 1 ? std::make_unique<Helpers>(threads) : nullptr) {}

ThreadTeam::~ThreadTeam() = default;

int ThreadTeam::threads() const { return helpers_ ? static_cast<int>(helpers_->shares.size()) : 1; }

void ThreadTeam::share(int parts, Call call, const void* work) {
  Helpers& h = *helpers_;
  const auto threads = static_cast<int>(h.shares.size());
  for (int t = 0; t < threads; ++t) {
    Helpers::Share& share = h.shares[static_cast<std::size_t>(t)];
    share.next.store(static_cast<int>(static_cast<std::int64_t>(parts) * t / threads),
                     std::memory_order_relaxed);
    share.end = static_cast<int>(static_cast<std::int64_t>(parts) * (t + 1) / threads);
  }
  h.call = call;
  h.work = work;
  h.gate.fetch_add(kNext | kOpen, std::memory_order_release);
  h.gate.notify_all();
  h.work_on(0);
  h.gate.fetch_sub(kOpen, std::memory_order_acq_rel);
  for (int look = 0; (h.gate.load(std::memory_order_acquire) & kInside) != 0; ++look) {
    if (look < kLooks) {
      pause_a_little();
    } else {
      std::this_thread::yield();
    }
  }
}

}  // namespace tandem::fem
