#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "protocol/contract/port.h"
#include "protocol/wire/seal.h"

namespace tandem::wire {

// The arrays of a message, exactly as lcm-gen's code lays out motion_t, wrench_t, double and byte,
// but from and to the types of the contract without an object of the generated type between.

inline constexpr std::size_t kMotionBytes = 13 * 8;
inline constexpr std::size_t kWrenchBytes = 6 * 8;

/// Writes arrays one behind the other; the caller has made room.
class ArrayWriter {
 public:
  explicit ArrayWriter(std::uint8_t* at) : at_(at) {}
  ArrayWriter& add(std::span<const Motion> motions);
  ArrayWriter& add(std::span<const Wrench> wrenches);
  ArrayWriter& add(std::span<const double> values);
  ArrayWriter& add(std::span<const char> text);

 private:
  std::uint8_t* at_;
};

/// Reads arrays one behind the other; the caller has checked that all of them are there.
class ArrayReader {
 public:
  explicit ArrayReader(const std::uint8_t* at) : at_(at) {}
  ArrayReader& take(std::size_t count, MotionSet& motions);
  ArrayReader& take(std::size_t count, WrenchSet& wrenches);
  ArrayReader& take(std::span<double> values);
  ArrayReader& take(std::size_t count, std::string& text);

 private:
  const std::uint8_t* at_;
};

/// Whether the array as it was written holds these bits (−0 differs from 0, a NaN equals itself).
[[nodiscard]] bool same_bits(std::span<const Motion> motions, ByteView written);
[[nodiscard]] bool same_bits(std::span<const Wrench> wrenches, ByteView written);

}  // namespace tandem::wire
