#include "protocol/wire/crc32.h"

#include <zlib.h>

#include <array>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace tandem::wire {
namespace {

std::uint32_t crc32_by_table(std::uint32_t crc, ByteView bytes) {
  return static_cast<std::uint32_t>(::crc32_z(crc, bytes.data(), bytes.size()));
}

#if defined(__x86_64__)

constexpr std::size_t kLane = 16;
constexpr std::size_t kBlock = 4 * kLane;
constexpr std::size_t kWide = 4 * kBlock;

// x^(d+32) and x^(d−32) mod P, reflected, for the distance d in bits by which a lane is moved.
__attribute__((target("pclmul,sse4.1"))) inline __m128i moved(__m128i lane, __m128i powers) {
  return _mm_xor_si128(_mm_clmulepi64_si128(lane, powers, 0x00),
                       _mm_clmulepi64_si128(lane, powers, 0x11));
}

__attribute__((target("pclmul,sse4.1"))) std::uint32_t crc32_by_folding(std::uint32_t crc,
                                                                        ByteView bytes) {
  const __m128i by_block = _mm_set_epi64x(0x01c6e41596, 0x0154442bd4);  // d = 512
  const __m128i by_lane = _mm_set_epi64x(0x00ccaa009e, 0x01751997d0);   // d = 128
  const auto load = [&bytes](std::size_t lane) __attribute__((target("pclmul,sse4.1"))) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes.data() + kLane * lane));
  };
  // The start value stands where the first 32 bits of the message do.
  __m128i a = _mm_xor_si128(load(0), _mm_cvtsi32_si128(static_cast<int>(~crc)));
  __m128i b = load(1);
  __m128i c = load(2);
  __m128i d = load(3);
  for (bytes = bytes.subspan(kBlock); bytes.size() >= kBlock; bytes = bytes.subspan(kBlock)) {
    a = _mm_xor_si128(moved(a, by_block), load(0));
    b = _mm_xor_si128(moved(b, by_block), load(1));
    c = _mm_xor_si128(moved(c, by_block), load(2));
    d = _mm_xor_si128(moved(d, by_block), load(3));
  }
  b = _mm_xor_si128(moved(a, by_lane), b);
  c = _mm_xor_si128(moved(b, by_lane), c);
  d = _mm_xor_si128(moved(c, by_lane), d);
  // These 16 bytes are congruent to all that was folded; the start value is in them already.
  std::array<std::uint8_t, kLane> rest{};
  _mm_storeu_si128(reinterpret_cast<__m128i*>(rest.data()), d);
  return crc32_by_table(crc32_by_table(0xffffffffU, rest), bytes);
}

// The same with four lanes to a register, 256 bytes at a time; ends in the four lanes a, b, c, d.
__attribute__((target("avx512f,vpclmulqdq"))) inline __m512i moved(__m512i lanes, __m512i powers,
                                                                   __m512i next) {
  constexpr int kXorOfThree = 0x96;
  return _mm512_ternarylogic_epi64(_mm512_clmulepi64_epi128(lanes, powers, 0x00),
                                   _mm512_clmulepi64_epi128(lanes, powers, 0x11), next,
                                   kXorOfThree);
}

/// Folds all whole 256-byte blocks of `bytes` into one block of 64 bytes and drops them from it.
__attribute__((target("avx512f,vpclmulqdq"))) std::array<std::uint8_t, kBlock> fold_wide(
    std::uint32_t crc, ByteView& bytes) {
  constexpr long long kLow = 0x11542778a;   // x^(2048+32) mod P, reflected
  constexpr long long kHigh = 0x1322d1430;  // x^(2048−32) mod P, reflected
  const __m512i by_four = _mm512_set_epi64(kHigh, kLow, kHigh, kLow, kHigh, kLow, kHigh, kLow);
  const __m512i by_one = _mm512_set_epi64(0x01c6e41596, 0x0154442bd4, 0x01c6e41596, 0x0154442bd4,
                                          0x01c6e41596, 0x0154442bd4, 0x01c6e41596, 0x0154442bd4);
  const std::uint8_t* at = bytes.data();
  const __m512i start = _mm512_zextsi128_si512(_mm_cvtsi32_si128(static_cast<int>(~crc)));
  __m512i a = _mm512_xor_si512(_mm512_loadu_si512(at), start);
  __m512i b = _mm512_loadu_si512(at + kBlock);
  __m512i c = _mm512_loadu_si512(at + 2 * kBlock);
  __m512i d = _mm512_loadu_si512(at + 3 * kBlock);
  for (bytes = bytes.subspan(kWide); bytes.size() >= kWide; bytes = bytes.subspan(kWide)) {
    at = bytes.data();
    a = moved(a, by_four, _mm512_loadu_si512(at));
    b = moved(b, by_four, _mm512_loadu_si512(at + kBlock));
    c = moved(c, by_four, _mm512_loadu_si512(at + 2 * kBlock));
    d = moved(d, by_four, _mm512_loadu_si512(at + 3 * kBlock));
  }
  b = moved(a, by_one, b);
  c = moved(b, by_one, c);
  d = moved(c, by_one, d);
  std::array<std::uint8_t, kBlock> block{};
  _mm512_storeu_si512(block.data(), d);
  return block;
}

bool can_fold() { return __builtin_cpu_supports("pclmul") && __builtin_cpu_supports("sse4.1"); }
bool can_fold_wide() {
  return can_fold() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("vpclmulqdq");
}

#endif

}  // namespace

std::uint32_t crc32(std::uint32_t crc, ByteView bytes) {
#if defined(__x86_64__)
  static const bool fold = can_fold();
  static const bool wide = can_fold_wide();
  if (wide && bytes.size() >= kWide) {
    const auto block = fold_wide(crc, bytes);
    // The start value is in the block already: ~0 starts with none.
    return crc32(crc32_by_folding(0xffffffffU, block), bytes);
  }
  if (fold && bytes.size() >= kBlock) return crc32_by_folding(crc, bytes);
#endif
  return crc32_by_table(crc, bytes);
}

std::uint32_t crc32_joined(std::uint32_t crc_a, std::uint32_t crc_b, std::size_t size_b) {
  return static_cast<std::uint32_t>(::crc32_combine(crc_a, crc_b, static_cast<z_off_t>(size_b)));
}

}  // namespace tandem::wire
