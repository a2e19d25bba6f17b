#include "fem_process/kernels/simd.h"

#include <algorithm>
#include <atomic>

namespace tandem::fem {
namespace {

VectorUnit detect() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") == 0) return VectorUnit::Plain;
  const bool avx512 =
      __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
      __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512bw") != 0;
  return avx512 ? VectorUnit::Avx512 : VectorUnit::Avx2;
#else
  return VectorUnit::Plain;
#endif
}

std::atomic<VectorUnit>& unit() {
  static std::atomic<VectorUnit> value{detect()};
  return value;
}

}  // namespace

VectorUnit vector_unit() { return unit().load(std::memory_order_relaxed); }

void limit_vector_unit(VectorUnit most) { unit().store(std::min(most, detect())); }

}  // namespace tandem::fem
