#pragma once

/// Kernels on vectors of a fixed number of lanes (GCC's and Clang's vector extension). The number
/// of lanes is part of the algorithm and no multiply-add is fused, so that the bits do not depend
/// on the processor; only the speed does.
///   TANDEM_INLINE          a piece of such a kernel: compiled for whoever calls it
///   TANDEM_VECTOR_FUNCTION(name, body, parameters, arguments)
///                          function `name` that calls `body` compiled for AVX2 where the processor
///                          has it, else for the build's own target
/// Chosen by a test rather than by an indirect function (ifunc), which sanitizers do not survive.
#define TANDEM_INLINE [[gnu::always_inline]] inline

#if defined(__x86_64__)
#define TANDEM_VECTOR_FUNCTION(name, body, parameters, arguments)         \
  [[gnu::target("avx2")]] void name##_avx2 parameters { body arguments; } \
  void name##_plain parameters { body arguments; }                        \
  void name parameters {                                                  \
    if (tandem::fem::has_avx2()) {                                        \
      name##_avx2 arguments;                                              \
    } else {                                                              \
      name##_plain arguments;                                             \
    }                                                                     \
  }
#else
#define TANDEM_VECTOR_FUNCTION(name, body, parameters, arguments) \
  void name parameters { body arguments; }
#endif

namespace tandem::fem {

#if defined(__x86_64__)
[[nodiscard]] inline bool has_avx2() {
  static const bool yes = __builtin_cpu_supports("avx2") != 0;
  return yes;
}
#endif

}  // namespace tandem::fem
