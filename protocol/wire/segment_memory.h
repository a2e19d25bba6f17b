#pragma once

#include <utility>

namespace tandem::wire {

/// What the server keeps of the inputs its side was given: the request for a segment that begins
/// where the last accepted one ended does not carry that value (RemoteLink::is_accepted() follows
/// the same rule from the same calls).
template <class In>
class SegmentMemory {
 public:
  /// The input at the end of an advance, or of the initialization. Takes the value, leaves an old
  /// one: no copy.
  void given(In& end) {
    std::swap(last_, end);
    open_ = true;
  }
  /// Checkpoint: the input given last is the accepted one.
  void accept() {
    if (std::exchange(open_, false)) std::swap(accepted_, last_);
  }
  /// To be lent to the segment of one advance, and taken back by a second call.
  void lend(In& begin) { std::swap(begin, accepted_); }

 private:
  In last_, accepted_;
  bool open_ = false;
};

}  // namespace tandem::wire
