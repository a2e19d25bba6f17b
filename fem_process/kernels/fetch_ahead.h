#pragma once

#include <cstddef>
#include <cstdint>

#include "fem_process/kernels/simd.h"

namespace tandem::fem {

/// Asks for the cache line that stands `bytes` behind `at` (negative: before it), whether or not it
/// still belongs to the array. Processors foresee streams, but neither one that runs backwards row
/// by row nor what an index names. Changes no bit of a result.
TANDEM_INLINE void fetch_ahead(const void* at, std::ptrdiff_t bytes) {
  const auto address = reinterpret_cast<std::uintptr_t>(at) + static_cast<std::uintptr_t>(bytes);
  __builtin_prefetch(reinterpret_cast<const void*>(address));
}

}  // namespace tandem::fem
