#pragma once

#include <utility>

#include "protocol/contract/segment.h"
#include "protocol/wire/arrays.h"

namespace tandem::wire {

/// What both ends of an exchange know of the inputs a side was given, by the same rule from the
/// same calls: a segment that begins where the last accepted one ended need not carry that value.
///   given(end)   the input at the end of an advance, or of the initialization
///   accept()     checkpoint: the input given last is the accepted one
template <class In>
class SegmentMemory {
 public:
  void given(const In& end) {
    last_ = end;
    open_ = true;
  }
  /// The same without a copy: takes the value, leaves an old one.
  void swap_given(In& end) {
    std::swap(last_, end);
    open_ = true;
  }
  void accept() {
    if (std::exchange(open_, false)) std::swap(accepted_, last_);
  }
  [[nodiscard]] bool is_accepted(const In& begin) const {
    return !begin.empty() && same_bits(begin, accepted_);
  }
  /// To be lent to the segment of one advance, and taken back by a second call.
  void lend(In& begin) { std::swap(begin, accepted_); }

 private:
  In last_, accepted_;
  bool open_ = false;
};

}  // namespace tandem::wire
