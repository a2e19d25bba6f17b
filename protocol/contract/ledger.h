#pragma once

#include <cstdint>

#include "protocol/contract/cost.h"

namespace tandem {

/// Where the wall time and the bytes of stepping went: of one macro step or, summed, of a run.
///   wall = mbs_compute + fem_compute + encode + decode + publish + transit + wait + scheme
///          + record + other − overlap
/// `discarded_s` is the part of the two compute times that was rolled back: contained in them, not
/// a further term of the sum. Durations only, each from one process's monotonic clock.
struct Ledger {
  double mbs_compute_s = 0.0;
  double fem_compute_s = 0.0;
  double encode_s = 0.0;     ///< values to bytes, both processes
  double decode_s = 0.0;     ///< checksum and bytes to values, both processes
  double publish_s = 0.0;    ///< sealing and sending, both processes
  double transit_s = 0.0;    ///< round trips minus everything both processes book themselves
  double wait_s = 0.0;       ///< blocked: credit of the recorder
  double scheme_s = 0.0;     ///< accelerator, linear algebra, norms
  double record_s = 0.0;     ///< journal and log
  double other_s = 0.0;      ///< wall time minus all of the above
  double overlap_s = 0.0;    ///< named time of one side that passed while the other computed
  double discarded_s = 0.0;  ///< compute time of calls that were rolled back
  std::int64_t messages = 0;
  std::int64_t bytes = 0;
  std::int64_t resent = 0;      ///< requests sent again after a time-out
  std::int64_t duplicates = 0;  ///< messages that arrived again and were not used
  std::int64_t lost = 0;        ///< messages known to have been lost or damaged on the way

  /// Adds what one call cost. Its compute time goes to the caller's column, which the caller books.
  void add_transfer(const CallCost& cost) {
    encode_s += cost.encode_s;
    decode_s += cost.decode_s;
    publish_s += cost.publish_s;
    transit_s += cost.transit_s;
    messages += cost.messages;
    bytes += cost.bytes;
    resent += cost.resent;
    duplicates += cost.duplicates;
  }

  /// A request that was sent again was late when its first copy turns up as a duplicate, else lost.
  void book_lost(std::int64_t damaged) {
    lost = damaged + (resent > duplicates ? resent - duplicates : 0);
  }

  /// The wall time that has a name: all terms of the sum but `other_s`.
  [[nodiscard]] double named_s() const {
    return mbs_compute_s + fem_compute_s + encode_s + decode_s + publish_s + transit_s + wait_s +
           scheme_s + record_s - overlap_s;
  }

  Ledger& operator+=(const Ledger& b) {
    mbs_compute_s += b.mbs_compute_s;
    fem_compute_s += b.fem_compute_s;
    encode_s += b.encode_s;
    decode_s += b.decode_s;
    publish_s += b.publish_s;
    transit_s += b.transit_s;
    wait_s += b.wait_s;
    scheme_s += b.scheme_s;
    record_s += b.record_s;
    other_s += b.other_s;
    overlap_s += b.overlap_s;
    discarded_s += b.discarded_s;
    messages += b.messages;
    bytes += b.bytes;
    resent += b.resent;
    duplicates += b.duplicates;
    lost += b.lost;
    return *this;
  }
};

}  // namespace tandem
