#pragma once

#include "fem_process/kernels/simd.h"

namespace tandem::fem {

/// Entries of two columns of a tile from their words, both times 2¹⁶. What the upper half inherits
/// from the lower one was allowed for in rounding.
template <class Registers>
TANDEM_INLINE void unpack(const int* words, typename Registers::Float16& even,
                          typename Registers::Float16& odd) {
  typename Registers::Int16 word;
  load(word, words);
  Registers::convert(word << 16, even);
  Registers::convert(word, odd);
}

}  // namespace tandem::fem
