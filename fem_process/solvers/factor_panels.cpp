#include "fem_process/solvers/factor_panels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "fem_process/kernels/panel_words.h"
#include "fem_process/kernels/simd.h"

namespace tandem::fem {
namespace {

constexpr int kTile = FactorPanels::kTile;

/// out = P x in `N` tiles of `pairs` column pairs each, `stride` words apart.
template <class Registers, int N>
TANDEM_INLINE void multiply_tiles(const int* words, std::size_t stride, int pairs, const float* x,
                                  float* out) {
  using Lanes = typename Registers::Float16;
  Lanes sum[2][N] = {};
  for (int q = 0; q < pairs; ++q) {
    for (int n = 0; n < N; ++n) {
      Lanes even;
      Lanes odd;
      unpack<Registers>(
          words + static_cast<std::size_t>(n) * stride + static_cast<std::size_t>(q) * kTile, even,
          odd);
      sum[0][n] += x[2 * q] * even;
      sum[1][n] += x[2 * q + 1] * odd;
    }
  }
  for (int n = 0; n < N; ++n) store(sum[0][n] + sum[1][n], out + n * kTile);
}

/// Tiles [begin, end) of which those before `full` belong to the triangle.
template <class Registers>
TANDEM_INLINE void multiply_body(const int* words, int pairs, int full, int begin, int end,
                                 const float* x, float* out) {
  int tile = begin;
  for (; tile < end && tile < full; ++tile) {
    const int own = kTile / 2 * (tile + 1);
    multiply_tiles<Registers, 1>(words, 0, own, x, out + tile * kTile);
    words += static_cast<std::size_t>(own) * kTile;
  }
  const std::size_t stride = static_cast<std::size_t>(pairs) * kTile;
  for (; tile + 4 <= end; tile += 4) {
    multiply_tiles<Registers, 4>(words, stride, pairs, x, out + tile * kTile);
    words += 4 * stride;
  }
  for (; tile < end; ++tile) {
    multiply_tiles<Registers, 1>(words, stride, pairs, x, out + tile * kTile);
    words += stride;
  }
}

TANDEM_REGISTER_FUNCTION(multiply_panel, multiply_body,
                         (const int* words, int pairs, int full, int begin, int end, const float* x,
                          float* out),
                         (words, pairs, full, begin, end, x, out))

/// sums += Pᵀ x of `N` tiles, column pairs [0, pairs).
template <class Registers, int N>
TANDEM_INLINE void add_transposed(const int* words, std::size_t stride, int pairs, const float* x,
                                  float* sums) {
  using Lanes = typename Registers::Float16;
  Lanes rows[N];
  for (int n = 0; n < N; ++n) load(rows[n], x + n * kTile);
  for (int q = 0; q < pairs; ++q) {
    float* const sum = sums + static_cast<std::ptrdiff_t>(2 * q) * kTile;
    Lanes total[2];
    load(total[0], sum);
    load(total[1], sum + kTile);
    for (int n = 0; n < N; ++n) {
      Lanes even;
      Lanes odd;
      unpack<Registers>(
          words + static_cast<std::size_t>(n) * stride + static_cast<std::size_t>(q) * kTile, even,
          odd);
      total[0] += rows[n] * even;
      total[1] += rows[n] * odd;
    }
    store(total[0], sum);
    store(total[1], sum + kTile);
  }
}

using Float8 = float __attribute__((vector_size(32)));
using Float4 = float __attribute__((vector_size(16)));

/// Sums over the lanes of four columns, in a fixed order.
TANDEM_INLINE void sum_lanes(const float* sums, float* out) {
  Float4 four[4];
  for (int c = 0; c < 4; ++c) {
    Float8 low;
    Float8 high;
    load(low, sums + c * kTile);
    load(high, sums + c * kTile + 8);
    low += high;
    const Float4 first = __builtin_shufflevector(low, low, 0, 1, 2, 3);
    const Float4 second = __builtin_shufflevector(low, low, 4, 5, 6, 7);
    four[c] = first + second;
  }
  const Float4 ab_low = __builtin_shufflevector(four[0], four[1], 0, 4, 1, 5);
  const Float4 ab_high = __builtin_shufflevector(four[0], four[1], 2, 6, 3, 7);
  const Float4 cd_low = __builtin_shufflevector(four[2], four[3], 0, 4, 1, 5);
  const Float4 cd_high = __builtin_shufflevector(four[2], four[3], 2, 6, 3, 7);
  const Float4 ab = ab_low + ab_high;  // a0 + a2, b0 + b2, a1 + a3, b1 + b3
  const Float4 cd = cd_low + cd_high;
  const Float4 total =
      __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
  store(total, out);
}

/// What a block of column pairs [begin, end) meets: `words` is the panel's first word.
template <class Registers>
TANDEM_INLINE void transposed_body(const int* words, int pairs, int tiles, int begin, int end,
                                   const float* x, float* sums, float* totals) {
  const int columns = (2 * (end - begin) + 3) / 4 * 4;
  std::fill(sums, sums + static_cast<std::ptrdiff_t>(kTile) * columns, 0.0F);
  int tile = 0;
  for (; tile < tiles && kTile / 2 * (tile + 1) < pairs; ++tile) {
    const int own = kTile / 2 * (tile + 1);
    if (begin < own) {
      add_transposed<Registers, 1>(words + static_cast<std::ptrdiff_t>(begin) * kTile, 0,
                                   std::min(own, end) - begin, x + tile * kTile, sums);
    }
    words += static_cast<std::ptrdiff_t>(own) * kTile;
  }
  words += static_cast<std::ptrdiff_t>(begin) * kTile;
  const std::size_t stride = static_cast<std::size_t>(pairs) * kTile;
  for (; tile + 4 <= tiles; tile += 4) {
    add_transposed<Registers, 4>(words, stride, end - begin, x + tile * kTile, sums);
    words += 4 * stride;
  }
  for (; tile < tiles; ++tile) {
    add_transposed<Registers, 1>(words, stride, end - begin, x + tile * kTile, sums);
    words += stride;
  }
  for (int k = 0; k < columns; k += 4) {
    sum_lanes(sums + static_cast<std::ptrdiff_t>(k) * kTile, totals + k);
  }
}

TANDEM_REGISTER_FUNCTION(transposed_panel, transposed_body,
                         (const int* words, int pairs, int tiles, int begin, int end,
                          const float* x, float* sums, float* totals),
                         (words, pairs, tiles, begin, end, x, sums, totals))

}  // namespace

std::size_t FactorPanels::tile_start(const Panel& panel, int tile) {
  // Triangular tiles have 8, 16, 24, … pairs, the others all of them.
  const int triangular = std::min(tile, panel.triangular());
  const auto n = static_cast<std::size_t>(triangular);
  const std::size_t before =
      kTile / 2 * (n * (n + 1) / 2) +
      static_cast<std::size_t>(tile - triangular) * static_cast<std::size_t>(panel.pairs());
  return panel.word + before * kTile;
}

FactorPanels::Panel FactorPanels::add(const Eigen::MatrixXd& values) {
  Panel panel{.columns = static_cast<int>(values.cols()),
              .rows = static_cast<int>(values.rows()),
              .word = word_.size(),
              .scale = scale_.size()};
  constexpr double kMost = 32767.0;
  for (Eigen::Index k = 0; k < values.cols(); ++k) {
    const double most = values.col(k).cwiseAbs().maxCoeff();
    scale_.push_back(static_cast<float>((most > 0.0 ? most : 1.0) / (kMost - 1.0) / 65536.0));
  }
  word_.resize(tile_start(panel, panel.tiles()), 0);
  const auto rounded = [&](Eigen::Index i, Eigen::Index k, double inherited) {
    if (i >= values.rows() || k >= values.cols()) return 0.0;
    const double unit =
        65536.0 * static_cast<double>(scale_[panel.scale + static_cast<std::size_t>(k)]);
    return std::nearbyint(values(i, k) / unit - inherited);
  };
  for (int tile = 0; tile < panel.tiles(); ++tile) {
    int* words = word_.data() + tile_start(panel, tile);
    for (int q = 0; q < panel.pairs(tile); ++q) {
      for (int i = 0; i < kTile; ++i) {
        const auto even =
            static_cast<std::uint16_t>(static_cast<int>(rounded(tile * kTile + i, 2 * q, 0.0)));
        const int odd = static_cast<int>(rounded(tile * kTile + i, 2 * q + 1, even / 65536.0));
        words[q * kTile + i] = static_cast<int>(static_cast<std::uint32_t>(odd) << 16 | even);
      }
    }
  }
  return panel;
}

void FactorPanels::scale(const Panel& panel, const float* x, float* scaled) const {
  const float* factor = scale_.data() + panel.scale;
  for (int k = 0; k < panel.columns; ++k) scaled[k] = factor[k] * x[k];
  if (panel.columns % 2 != 0) scaled[panel.columns] = 0.0F;
}

void FactorPanels::multiply(const Panel& panel, const float* scaled, int begin, int end,
                            float* out) const {
  multiply_panel(word_.data() + tile_start(panel, begin), panel.pairs(), panel.triangular(), begin,
                 end, scaled, out);
}

void FactorPanels::multiply_transposed(const Panel& panel, const float* x, int begin, int end,
                                       float* out) const {
  // Two columns more: the last four may be two.
  alignas(64) float sums[2 * (kPairs + 1) * kTile];
  float totals[2 * (kPairs + 1)];
  const float* factor = scale_.data() + panel.scale;
  for (int from = begin; from < end; from += kPairs) {
    const int to = std::min(from + kPairs, end);
    transposed_panel(word_.data() + panel.word, panel.pairs(), panel.tiles(), from, to, x, sums,
                     totals);
    for (int k = 2 * from; k < std::min(2 * to, panel.columns); ++k) {
      out[k] = factor[k] * totals[k - 2 * from];
    }
  }
}

}  // namespace tandem::fem
