#include "protocol/wire/poll_budget.h"

#include <algorithm>

namespace tandem::wire {
namespace {

constexpr int kFirstPause = 16;
constexpr int kLongestPause = 4096;
/// Polled waits without a preemption after which the next one counts as the first.
constexpr int kForgotten = 256;
constexpr double kMargin = 2.0;
constexpr double kLeast_s = 5e-5;
/// Part of `usual_s_` that a shorter wait leaves.
constexpr double kFading = 0.9;

}  // namespace

double PollBudget::begin() {
  if (wait_ == Wait::Block) return 0.0;
  if (wait_ == Wait::Poll) return kLongest_s;
  if (left_off_ > 0) {
    --left_off_;
    return 0.0;
  }
  if (usual_s_ > kLongest_s) return 0.0;
  return std::min(kLongest_s, kLeast_s + kMargin * usual_s_);
}

void PollBudget::preempted() {
  if (wait_ == Wait::Poll) return;
  pause_ =
      undisturbed_ >= kForgotten ? kFirstPause : std::clamp(2 * pause_, kFirstPause, kLongestPause);
  left_off_ = pause_;
  undisturbed_ = 0;
}

void PollBudget::end(double waited_s) {
  usual_s_ = std::max(waited_s, kFading * usual_s_);
  if (left_off_ == 0) ++undisturbed_;
}

}  // namespace tandem::wire
