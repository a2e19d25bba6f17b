#include "fem_process/simd.h"

#include <cstdlib>
#include <string_view>

namespace tandem::fem {
namespace {

VectorUnit detect() {
#if defined(__x86_64__)
  const char* text = std::getenv("TANDEM_VECTOR_UNIT");
  const std::string_view wish = text != nullptr ? text : "";
  if (wish == "plain" || __builtin_cpu_supports("avx2") == 0) return VectorUnit::Plain;
  const bool avx512 = __builtin_cpu_supports("avx512f") != 0 &&
                      __builtin_cpu_supports("avx512vl") != 0 &&
                      __builtin_cpu_supports("avx512dq") != 0 &&
                      __builtin_cpu_supports("avx512bw") != 0;
  return wish == "avx2" || !avx512 ? VectorUnit::Avx2 : VectorUnit::Avx512;
#else
  return VectorUnit::Plain;
#endif
}

}  // namespace

VectorUnit vector_unit() {
  static const VectorUnit unit = detect();
  return unit;
}

}  // namespace tandem::fem
