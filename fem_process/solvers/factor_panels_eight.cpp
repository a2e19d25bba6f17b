#include <algorithm>

#include "fem_process/kernels/panel_words.h"
#include "fem_process/kernels/simd.h"
#include "fem_process/solvers/factor_panels.h"

namespace tandem::fem {
namespace {

constexpr int kTile = FactorPanels::kTile;
constexpr int kWidth = 8;  ///< vectors side by side

using Float8 = float __attribute__((vector_size(32)));

TANDEM_INLINE void interleave(const Float8& a, const Float8& b, Float8& low, Float8& high) {
  low = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
  high = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
}

TANDEM_INLINE void interleave_pairs(const Float8& a, const Float8& b, Float8& low, Float8& high) {
  low = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
  high = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
}

/// The 8 × 8 matrix of these rows, transposed.
TANDEM_INLINE void transpose_eight(Float8 (&a)[8]) {
  Float8 t[8];
  Float8 s[8];
  for (int k = 0; k < 8; k += 2) interleave(a[k], a[k + 1], t[k], t[k + 1]);
  for (int k = 0; k < 8; k += 4) {
    interleave_pairs(t[k], t[k + 2], s[k], s[k + 1]);
    interleave_pairs(t[k + 1], t[k + 3], s[k + 2], s[k + 3]);
  }
  for (int k = 0; k < 4; ++k) {
    a[k] = __builtin_shufflevector(s[k], s[k + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    a[k + 4] = __builtin_shufflevector(s[k], s[k + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

/// One tile of P times `N` vectors.
template <class Registers, int N>
TANDEM_INLINE void multiply_tile(const int* words, int pairs, const float* x, float* out) {
  using Lanes = typename Registers::Float16;
  Lanes sum[N] = {};
  for (int q = 0; q < pairs; ++q) {
    Lanes even;
    Lanes odd;
    unpack<Registers>(words + q * kTile, even, odd);
    const float* const at = x + 2 * kWidth * q;
    for (int c = 0; c < N; ++c) sum[c] += at[c] * even;
    for (int c = 0; c < N; ++c) sum[c] += at[kWidth + c] * odd;
  }
  alignas(64) float lanes[N * kTile];
  for (int c = 0; c < N; ++c) store(sum[c], lanes + c * kTile);
  for (int half = 0; half < 2; ++half) {
    Float8 rows[8] = {};
    for (int c = 0; c < N; ++c) load(rows[c], lanes + c * kTile + 8 * half);
    transpose_eight(rows);
    for (int k = 0; k < 8; ++k) store(rows[k], out + kWidth * (8 * half + k));
  }
}

/// Tiles [begin, end) of which those before `full` belong to the triangle.
template <class Registers>
TANDEM_INLINE void multiply_eight_body(const int* words, int pairs, int full, int vectors,
                                       int begin, int end, const float* x, float* out) {
  for (int tile = begin; tile < end; ++tile) {
    const int own = tile < full ? kTile / 2 * (tile + 1) : pairs;
    float* const to = out + static_cast<std::ptrdiff_t>(tile) * kTile * kWidth;
    if (vectors <= 4) {
      multiply_tile<Registers, 4>(words, own, x, to);
    } else if (vectors <= 6) {
      multiply_tile<Registers, 6>(words, own, x, to);
    } else {
      multiply_tile<Registers, 8>(words, own, x, to);
    }
    words += static_cast<std::ptrdiff_t>(own) * kTile;
  }
}

TANDEM_REGISTER_FUNCTION(multiply_panel_eight, multiply_eight_body,
                         (const int* words, int pairs, int full, int vectors, int begin, int end,
                          const float* x, float* out),
                         (words, pairs, full, vectors, begin, end, x, out))

/// Two columns of P times `N` vectors: sums over the rows in their lanes, then over the lanes.
template <class Registers, int N>
TANDEM_INLINE void multiply_columns(const int* words, int pairs, int full, int tiles, int q,
                                    const float* x, float* out) {
  using Lanes = typename Registers::Float16;
  Lanes total[2][N] = {};
  for (int tile = q / (kTile / 2); tile < tiles; ++tile) {
    const int whole = std::min(tile, full);
    const int before = kTile / 4 * whole * (whole + 1) + (tile - whole) * pairs + q;
    Lanes even;
    Lanes odd;
    unpack<Registers>(words + static_cast<std::ptrdiff_t>(before) * kTile, even, odd);
    const float* const rows = x + static_cast<std::ptrdiff_t>(tile) * kTile * kWidth;
    for (int c = 0; c < N; ++c) {
      Lanes row;
      load(row, rows + c * kTile);
      total[0][c] += row * even;
      total[1][c] += row * odd;
    }
  }
  alignas(64) float lanes[kTile];
  for (int column = 0; column < 2; ++column) {
    Float8 sum[8] = {};
    for (int c = 0; c < N; ++c) {
      store(total[column][c], lanes);
      Float8 high;
      load(sum[c], lanes);
      load(high, lanes + 8);
      sum[c] += high;
    }
    transpose_eight(sum);
    const Float8 all =
        ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
    store(all, out + kWidth * column);
  }
}

template <class Registers>
TANDEM_INLINE void transposed_eight_body(const int* words, int pairs, int full, int tiles,
                                         int vectors, int begin, int end, const float* x,
                                         float* out) {
  for (int q = begin; q < end; ++q) {
    float* const to = out + static_cast<std::ptrdiff_t>(2 * (q - begin)) * kWidth;
    if (vectors <= 4) {
      multiply_columns<Registers, 4>(words, pairs, full, tiles, q, x, to);
    } else if (vectors <= 6) {
      multiply_columns<Registers, 6>(words, pairs, full, tiles, q, x, to);
    } else {
      multiply_columns<Registers, 8>(words, pairs, full, tiles, q, x, to);
    }
  }
}

TANDEM_REGISTER_FUNCTION(transposed_panel_eight, transposed_eight_body,
                         (const int* words, int pairs, int full, int tiles, int vectors, int begin,
                          int end, const float* x, float* out),
                         (words, pairs, full, tiles, vectors, begin, end, x, out))

TANDEM_INLINE void lay_out_body(const float* rows, int tiles, float* out) {
  for (int tile = 0; tile < tiles; ++tile) {
    for (int half = 0; half < 2; ++half) {
      Float8 a[8];
      for (int k = 0; k < 8; ++k) load(a[k], rows + kWidth * (8 * half + k));
      transpose_eight(a);
      for (int c = 0; c < 8; ++c) store(a[c], out + c * kTile + 8 * half);
    }
    rows += kTile * kWidth;
    out += kTile * kWidth;
  }
}

TANDEM_VECTOR_FUNCTION(lay_out, lay_out_body, (const float* rows, int tiles, float* out),
                       (rows, tiles, out))

TANDEM_INLINE void scale_body(const float* factor, int columns, const float* x, float* scaled) {
  for (int k = 0; k < columns; ++k) {
    Float8 value;
    load(value, x + kWidth * k);
    value = factor[k] * value;
    store(value, scaled + kWidth * k);
  }
}

TANDEM_VECTOR_FUNCTION(scale_columns, scale_body,
                       (const float* factor, int columns, const float* x, float* scaled),
                       (factor, columns, x, scaled))

}  // namespace

void FactorPanels::scale_eight(const Panel& panel, const float* x, float* scaled) const {
  scale_columns(scale_.data() + panel.scale, panel.columns, x, scaled);
  if (panel.columns % 2 != 0) std::fill_n(scaled + kWidth * panel.columns, kWidth, 0.0F);
}

void FactorPanels::multiply_eight(const Panel& panel, const float* scaled, int vectors, int begin,
                                  int end, float* out) const {
  multiply_panel_eight(word_.data() + tile_start(panel, begin), panel.pairs(), panel.triangular(),
                       vectors, begin, end, scaled, out);
}

void FactorPanels::multiply_transposed_eight(const Panel& panel, const float* tiles, int vectors,
                                             int begin, int end, float* out) const {
  alignas(64) float totals[2 * kPairs * kWidth];
  const float* factor = scale_.data() + panel.scale;
  for (int from = begin; from < end; from += kPairs) {
    const int to = std::min(from + kPairs, end);
    transposed_panel_eight(word_.data() + panel.word, panel.pairs(), panel.triangular(),
                           panel.tiles(), vectors, from, to, tiles, totals);
    const int count = std::min(2 * to, panel.columns) - 2 * from;
    scale_columns(factor + 2 * from, count, totals, out + kWidth * 2 * from);
  }
}

void FactorPanels::lay_out_tiles(const float* rows, int count, float* tiles) {
  lay_out(rows, (count + kTile - 1) / kTile, tiles);
}

}  // namespace tandem::fem
