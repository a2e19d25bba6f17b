#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tandem {

/// 64-bit FNV-1a over a sequence of 64-bit words [Fowler, Noll, Vo 1991]: a fingerprint of a
/// state's bits for comparing runs, not a defence against forgery.
class StateHash {
 public:
  void add(std::uint64_t word) {
    for (int shift = 0; shift < 64; shift += 8) {
      value_ ^= (word >> shift) & 0xffU;
      value_ *= 0x100000001b3ULL;
    }
  }
  void add(double x) { add(std::bit_cast<std::uint64_t>(x)); }
  void add(std::int64_t x) { add(std::bit_cast<std::uint64_t>(x)); }
  void add(std::span<const double> values) {
    for (double x : values) add(x);
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

}  // namespace tandem
