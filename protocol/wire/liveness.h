#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "protocol/wire/bus.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

/// Says "alive" in the background as long as the process lives, however long a solver step takes; a
/// stopped or killed process falls silent. One per process, started before the model is loaded.
class Heartbeat {
 public:
  /// Publishes every min(0.2 s, timeout / 5).
  Heartbeat(Bus& bus, double timeout_s);
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /// What the process is doing, for the orchestrator's display: "loading the mesh", "waiting for
  /// tandem-fem". Published at once.
  void set_phase(const std::string& phase);
  void set_macro_step(std::int64_t macro_step) { macro_step_ = macro_step; }

 private:
  void loop();
  Bus& bus_;
  double period_s_;
  std::atomic<std::int64_t> macro_step_{0};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string phase_ = "starting";
  bool stop_ = false;
  bool say_now_ = true;
  std::thread thread_;
};

/// Tells the others why this process ends; repeated a few times, since messages may be lost.
void publish_abort(Bus& bus, int exit_code, const std::string& text);

/// Watches the partners of this process. All waiting of the wire layers goes through wait(), so
/// that no loop outlives a dead partner.
class LivenessMonitor {
 public:
  /// `parent_pid` > 0: also ends when that process is no longer our parent.
  LivenessMonitor(Bus& bus, std::vector<Process> partners, double timeout_s, int parent_pid = 0);
  LivenessMonitor(const LivenessMonitor&) = delete;
  LivenessMonitor& operator=(const LivenessMonitor&) = delete;

  /// Pumps the bus once, for at most `seconds`; true when something arrived. Throws tandem::Error
  /// when a partner is silent for longer than the time-out (ErrorKind::Partner), or has said that
  /// it failed (kind by its exit code).
  bool wait(double seconds);

  /// Ends watching one partner: it has said that it is done, or its process has ended with exit
  /// code 0. The orchestrator calls this for each child that has left in peace.
  void release(Process partner);

  /// `look` is called again and again while wait() has nothing to handle: what else may end the
  /// waiting (a child process, a signal) throws from there.
  void also_watch(std::function<void()> look) { also_watch_ = std::move(look); }

  /// What is known here of a flexible body that the error text is about: whether it was asked.
  void tell_of_bodies(std::function<std::string(Process)> tell) { tell_ = std::move(tell); }

  /// For the error text.
  void set_macro_step(std::int64_t macro_step) { macro_step_ = macro_step; }

  /// What the partner last said it was doing; empty = nothing heard yet.
  [[nodiscard]] const std::string& phase(Process partner) const;
  [[nodiscard]] std::int64_t macro_step(Process partner) const;
  [[nodiscard]] bool heard_from(Process partner) const;
  [[nodiscard]] double timeout_s() const { return timeout_s_; }

 private:
  struct Partner {
    Process process{};
    std::int64_t heard = 0;  ///< Bus::heard() when last looked at
    double deadline_s = 0.0;
    bool grace_given = false;
    bool released = false;
    std::int64_t macro_step = 0;
    std::string phase;
    Subscription alive, abort;
  };
  void look(double time_s);
  void check(double time_s);
  void on_abort(const Abort& abort) const;
  [[noreturn]] void fail_silent(const Partner& partner) const;
  [[nodiscard]] std::string others_than(const Partner& silent) const;
  [[nodiscard]] const Partner* find(Process process) const;

  Bus& bus_;
  std::vector<Partner> partners_;
  double timeout_s_;
  int parent_pid_;
  double last_check_s_ = 0.0;
  std::int64_t macro_step_ = 0;
  std::function<void()> also_watch_;
  std::function<std::string(Process)> tell_;
};

}  // namespace tandem::wire
