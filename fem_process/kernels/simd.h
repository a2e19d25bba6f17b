#pragma once

#include <cstring>

/// Kernels on vectors of a fixed number of lanes (GCC's and Clang's vector extension). The number
/// of lanes is part of the algorithm and no multiply-add is fused, so that the bits do not depend
/// on the processor; only the speed does.
///   TANDEM_INLINE          a piece of such a kernel: compiled for whoever calls it
///   TANDEM_VECTOR_FUNCTION(name, body, parameters, arguments)
///                          function `name` that calls `body` compiled for AVX-512 or AVX2 where
///                          the processor has it, else for the build's own target
///   TANDEM_REGISTER_FUNCTION(name, body, parameters, arguments)
///                          the same for a template: `body<WideRegisters>` for AVX-512, else
///                          `body<NarrowRegisters>`
/// Chosen by a test rather than by an indirect function (ifunc), which sanitizers do not survive.
#define TANDEM_INLINE [[gnu::always_inline]] inline
#define TANDEM_VECTOR_FUNCTION(name, body, parameters, arguments) \
  TANDEM_DISPATCH(name, body, body, parameters, arguments)
#define TANDEM_REGISTER_FUNCTION(name, body, parameters, arguments)                           \
  TANDEM_DISPATCH(name, body<tandem::fem::WideRegisters>, body<tandem::fem::NarrowRegisters>, \
                  parameters, arguments)

// GCC prefers registers of half the width unless it is told; Clang knows no such word here.
#if defined(__clang__)
#define TANDEM_AVX512 "avx512f,avx512vl,avx512dq,avx512bw"
#else
#define TANDEM_AVX512 "avx512f,avx512vl,avx512dq,avx512bw,prefer-vector-width=512"
#endif

#if defined(__x86_64__)
#define TANDEM_DISPATCH(name, wide, narrow, parameters, arguments)                 \
  [[gnu::target(TANDEM_AVX512)]] void name##_avx512 parameters { wide arguments; } \
  [[gnu::target("avx2")]] void name##_avx2 parameters { narrow arguments; }        \
  void name##_plain parameters { narrow arguments; }                               \
  void name parameters {                                                           \
    switch (tandem::fem::vector_unit()) {                                          \
      case tandem::fem::VectorUnit::Avx512:                                        \
        return name##_avx512 arguments;                                            \
      case tandem::fem::VectorUnit::Avx2:                                          \
        return name##_avx2 arguments;                                              \
      default:                                                                     \
        return name##_plain arguments;                                             \
    }                                                                              \
  }
#else
#define TANDEM_DISPATCH(name, wide, narrow, parameters, arguments) \
  void name parameters { narrow arguments; }
#endif

namespace tandem::fem {

enum class VectorUnit { Plain, Avx2, Avx512 };

/// The best that the processor has.
[[nodiscard]] VectorUnit vector_unit();
/// Asks for less than that, to see that the bits are the same. Of the whole program.
void limit_vector_unit(VectorUnit most);

/// Four numbers, most often the three of a node and a zero.
using Double4 = double __attribute__((vector_size(32)));

/// Twice as many lanes as a register of AVX2 has. Compilers keep vectors that are longer than a
/// register in memory; halves stay in registers.
template <class Half>
struct Pair {
  Half low;
  Half high;
};
template <class Half>
TANDEM_INLINE Pair<Half> operator+(const Pair<Half>& a, const Pair<Half>& b) {
  return {a.low + b.low, a.high + b.high};
}
template <class Half>
TANDEM_INLINE Pair<Half> operator-(const Pair<Half>& a, const Pair<Half>& b) {
  return {a.low - b.low, a.high - b.high};
}
template <class Half>
TANDEM_INLINE Pair<Half> operator*(const Pair<Half>& a, const Pair<Half>& b) {
  return {a.low * b.low, a.high * b.high};
}
template <class Half>
TANDEM_INLINE Pair<Half> operator-(const Pair<Half>& a) {
  return {-a.low, -a.high};
}
template <class Half, class Number>
TANDEM_INLINE Pair<Half> operator*(Number a, const Pair<Half>& b) {
  return {a * b.low, a * b.high};
}
template <class Half, class Number>
TANDEM_INLINE Pair<Half> operator-(const Pair<Half>& a, Number b) {
  return {a.low - b, a.high - b};
}
template <class Half, class Number>
TANDEM_INLINE Pair<Half> operator/(Number a, const Pair<Half>& b) {
  return {a / b.low, a / b.high};
}
template <class Half>
TANDEM_INLINE Pair<Half> operator<<(const Pair<Half>& a, int bits) {
  return {a.low << bits, a.high << bits};
}
template <class Half>
TANDEM_INLINE void operator+=(Pair<Half>& a, const Pair<Half>& b) {
  a.low += b.low;
  a.high += b.high;
}

/// Types of the lanes in registers of 512 bits, and of 256 or fewer.
struct WideRegisters {
  using Double8 = double __attribute__((vector_size(64)));
  using Float16 = float __attribute__((vector_size(64)));
  using Int16 = int __attribute__((vector_size(64)));
  TANDEM_INLINE static void split(const Double8& from, Double4& low, Double4& high) {
    low = __builtin_shufflevector(from, from, 0, 1, 2, 3);
    high = __builtin_shufflevector(from, from, 4, 5, 6, 7);
  }
  TANDEM_INLINE static void join(const Double4& low, const Double4& high, Double8& to) {
    to = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  }
  TANDEM_INLINE static void convert(const Int16& from, Float16& to) {
    to = __builtin_convertvector(from, Float16);
  }
};
struct NarrowRegisters {
  using Float8 = float __attribute__((vector_size(32)));
  using Int8 = int __attribute__((vector_size(32)));
  using Double8 = Pair<Double4>;
  using Float16 = Pair<Float8>;
  using Int16 = Pair<Int8>;
  TANDEM_INLINE static void split(const Double8& from, Double4& low, Double4& high) {
    low = from.low;
    high = from.high;
  }
  TANDEM_INLINE static void join(const Double4& low, const Double4& high, Double8& to) {
    to = {low, high};
  }
  TANDEM_INLINE static void convert(const Int16& from, Float16& to) {
    to = {__builtin_convertvector(from.low, Float8), __builtin_convertvector(from.high, Float8)};
  }
};

template <class Lanes, class Number>
TANDEM_INLINE void load(Lanes& lanes, const Number* from) {
  std::memcpy(&lanes, from, sizeof lanes);
}
template <class Lanes, class Number>
TANDEM_INLINE void store(const Lanes& lanes, Number* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}

/// The 4 × 4 matrix of these rows, transposed.
TANDEM_INLINE void transpose(Double4& a, Double4& b, Double4& c, Double4& d) {
  const Double4 ab_low = __builtin_shufflevector(a, b, 0, 4, 2, 6);
  const Double4 ab_high = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Double4 cd_low = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  const Double4 cd_high = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
  c = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
  d = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
}

/// Three numbers of eight elements → (x, y, z, 0) of each element, `stride` apart.
template <class Registers>
TANDEM_INLINE void scatter_lanes(const typename Registers::Double8& x,
                                 const typename Registers::Double8& y,
                                 const typename Registers::Double8& z, double* to, int stride) {
  Double4 a[2];
  Double4 b[2];
  Double4 c[2];
  Registers::split(x, a[0], a[1]);
  Registers::split(y, b[0], b[1]);
  Registers::split(z, c[0], c[1]);
  for (int half = 0; half < 2; ++half) {
    Double4 d{};
    transpose(a[half], b[half], c[half], d);
    store(a[half], to + 4 * half * stride);
    store(b[half], to + (4 * half + 1) * stride);
    store(c[half], to + (4 * half + 2) * stride);
    store(d, to + (4 * half + 3) * stride);
  }
}

/// The reverse, of eight vectors of four numbers.
template <class Registers>
TANDEM_INLINE void gather_lanes(const Double4 (&from)[8], typename Registers::Double8& x,
                                typename Registers::Double8& y, typename Registers::Double8& z) {
  Double4 a[4] = {from[0], from[1], from[2], from[3]};
  Double4 b[4] = {from[4], from[5], from[6], from[7]};
  transpose(a[0], a[1], a[2], a[3]);
  transpose(b[0], b[1], b[2], b[3]);
  Registers::join(a[0], b[0], x);
  Registers::join(a[1], b[1], y);
  Registers::join(a[2], b[2], z);
}

/// A node's vector or that of a corner: three numbers and a zero, on half a cache line.
struct alignas(32) Padded {
  double at[4];
};

}  // namespace tandem::fem
