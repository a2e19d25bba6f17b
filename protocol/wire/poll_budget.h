#pragma once

namespace tandem::wire {

/// How a receiver waits for the next datagram. The same bits come in either way.
enum class Wait {
  Adaptive,  ///< polls for a time before it blocks, where that takes no core from anybody
  Block,     ///< sleeps in the kernel at once
  Poll,      ///< polls for as long as most waits last, whoever else needs the core
};

/// How long a receiver polls its socket before it blocks in it. Being woken on another core costs
/// ten times what a datagram takes to a receiver that polls (100 µs and 5 µs there and back between
/// two cores); a receiver that polls keeps its core busy. So it polls
/// * about as long as the last waits took, and not at all where they were longer than kLongest_s:
///   beside such a wait the wake-up is small;
/// * not for some time after it has lost its core while polling: others need it. The more often
///   that happens, the longer it leaves off.
class PollBudget {
 public:
  static constexpr double kLongest_s = 2e-3;
  /// Between two looks at the socket; longer: another thread computes on this core. One that does
  /// little and sleeps again, as the recorder does after every macro step, takes less: it gets the
  /// core at once, since a receiver that polls gives way at every look.
  static constexpr double kPreempted_s = 1e-3;

  explicit PollBudget(Wait wait) : wait_(wait) {}

  /// For the wait that begins (s); 0: block at once.
  [[nodiscard]] double begin();
  /// The core was lost while polling.
  void preempted();
  /// A datagram has come after `waited_s`.
  void end(double waited_s);

 private:
  Wait wait_;
  double usual_s_ = 0.0;  ///< what waits took lately, long ones counted most
  int pause_ = 0;         ///< waits for which polling is left off, at the next preemption
  int left_off_ = 0;      ///< of them still to come
  int undisturbed_ = 0;   ///< polled waits since the last preemption
};

}  // namespace tandem::wire
