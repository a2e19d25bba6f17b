#include "fem_process/solvers/gauss_seidel.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "fem_process/kernels/fetch_ahead.h"
#include "fem_process/kernels/simd.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

using Float4 = float __attribute__((vector_size(16)));

/// Nodes of a tile: enough for a thread, few enough for several tiles a colour.
constexpr std::size_t kTile = 128;

/// Bytes of blocks that a sweep asks for ahead: some hundred blocks, the time of a line's way
/// from memory. Half of it gains less.
constexpr std::ptrdiff_t kAhead = 4096;

struct Matrix {
  const GaussSeidel::Row* row;
  const int* column;
  const float* value;
  const Padded4* inverse_diagonal;
};

/// Σ A_ij x_j of the blocks [begin, end), its fourth lane zero. The last column of a block is
/// read with the number before it, so that nothing behind the block is touched; what that gives
/// is thrown away. `Way`: 1 in a sweep upwards, −1 in one downwards.
template <int Way>
TANDEM_INLINE Float4 sum_blocks(const Matrix& A, int begin, int end, const Padded4* x) {
  Float4 sum[3] = {};
  for (int b = begin; b < end; ++b) {
    const float* const block = A.value + 9 * static_cast<std::ptrdiff_t>(b);
    fetch_ahead(block, Way * kAhead);
    const float* const x_j = x[A.column[b]].at;
    Float4 a[3];
    load(a[0], block);
    load(a[1], block + 3);
    load(a[2], block + 5);
    for (int k = 0; k < 3; ++k) sum[k] += x_j[k] * a[k];
  }
  const Float4 total = sum[0] + sum[1] + __builtin_shufflevector(sum[2], sum[2], 1, 2, 3, 0);
  return __builtin_shufflevector(total, Float4{}, 0, 1, 2, 4);
}

/// x_i = D⁻¹ (r_i − sum).
TANDEM_INLINE void solve_node(const Matrix& A, int i, const Float4& sum, const Padded4* r,
                              Padded4* x) {
  Float4 left;
  load(left, r[i].at);
  left -= sum;
  Float4 column[3];
  for (int k = 0; k < 3; ++k) load(column[k], A.inverse_diagonal[3 * i + k].at);
  const Float4 x_i = (left[0] * column[0] + left[1] * column[1]) + left[2] * column[2];
  store(x_i, x[i].at);
}

TANDEM_INLINE void forward_body(const Matrix& A, int begin, int end, const Padded4* r, Padded4* x) {
  for (int i = begin; i < end; ++i) {
    solve_node(A, i, sum_blocks<1>(A, A.row[i].first, A.row[i].middle, x), r, x);
  }
}

TANDEM_INLINE void residual_body(const Matrix& A, int begin, int end, const Padded4* x,
                                 Padded4* left) {
  for (int i = begin; i < end; ++i) {
    const Float4 sum = -sum_blocks<1>(A, A.row[i].middle, A.row[i + 1].first, x);
    store(sum, left[i].at);
  }
}

TANDEM_INLINE void backward_body(const Matrix& A, int begin, int end, const Padded4* r,
                                 Padded4* x) {
  for (int i = end - 1; i >= begin; --i) {
    solve_node(A, i, sum_blocks<-1>(A, A.row[i].first, A.row[i + 1].first, x), r, x);
  }
}

TANDEM_VECTOR_FUNCTION(sweep_forward, forward_body,
                       (const Matrix& A, int begin, int end, const Padded4* r, Padded4* x),
                       (A, begin, end, r, x))
TANDEM_VECTOR_FUNCTION(sweep_residual, residual_body,
                       (const Matrix& A, int begin, int end, const Padded4* x, Padded4* left),
                       (A, begin, end, x, left))
TANDEM_VECTOR_FUNCTION(sweep_backward, backward_body,
                       (const Matrix& A, int begin, int end, const Padded4* r, Padded4* x),
                       (A, begin, end, r, x))

/// The tiles' colours: each the first that no neighbour before it has.
std::vector<int> colours_of(const BlockPattern& pattern, const std::vector<int>& tile_of,
                            const std::vector<int>& near, int tiles) {
  std::vector<int> colour(static_cast<std::size_t>(tiles), -1);
  std::size_t at = 0;
  for (int t = 0; t < tiles; ++t) {
    std::vector<bool> taken(64, false);
    for (; at < near.size() && tile_of[static_cast<std::size_t>(near[at])] == t; ++at) {
      const auto i = static_cast<std::size_t>(near[at]);
      for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
        const auto j = static_cast<std::size_t>(pattern.column[static_cast<std::size_t>(b)]);
        const int other = colour[static_cast<std::size_t>(tile_of[j])];
        if (other < 0) continue;
        if (static_cast<std::size_t>(other) >= taken.size()) taken.resize(2 * taken.size(), false);
        taken[static_cast<std::size_t>(other)] = true;
      }
    }
    const auto free = std::find(taken.begin(), taken.end(), false);
    colour[static_cast<std::size_t>(t)] = static_cast<int>(free - taken.begin());
  }
  return colour;
}

}  // namespace

GaussSeidel::GaussSeidel(const BlockPattern& pattern, const BlockValues& A,
                         const std::vector<int>& near) {
  set_order(pattern, near);
  set_values(pattern, A);
}

void GaussSeidel::set_order(const BlockPattern& pattern, const std::vector<int>& near) {
  const auto n = static_cast<std::size_t>(pattern.rows());
  std::vector<int> tile_of(n);
  for (std::size_t k = 0; k < n; ++k) {
    tile_of[static_cast<std::size_t>(near[k])] = static_cast<int>(k / kTile);
  }
  const auto tiles = static_cast<int>((n + kTile - 1) / kTile);
  const std::vector<int> colour = colours_of(pattern, tile_of, near, tiles);
  std::vector<int> by_colour(static_cast<std::size_t>(tiles));
  std::iota(by_colour.begin(), by_colour.end(), 0);
  std::stable_sort(by_colour.begin(), by_colour.end(), [&](int a, int b) {
    return colour[static_cast<std::size_t>(a)] < colour[static_cast<std::size_t>(b)];
  });
  int last = -1;
  for (std::size_t t = 0; t < by_colour.size(); ++t) {
    const auto tile = static_cast<std::size_t>(by_colour[t]);
    if (colour[tile] != last) colour_start_.push_back(static_cast<int>(t));
    last = colour[tile];
    tile_start_.push_back(static_cast<int>(node_.size()));
    const auto begin = near.begin() + static_cast<std::ptrdiff_t>(tile * kTile);
    const auto count = static_cast<std::ptrdiff_t>(std::min(kTile, n - tile * kTile));
    node_.insert(node_.end(), begin, begin + count);
  }
  colour_start_.push_back(tiles);
  tile_start_.push_back(static_cast<int>(n));
}

void GaussSeidel::set_values(const BlockPattern& pattern, const BlockValues& A) {
  const std::size_t n = node_.size();
  std::vector<int> place(n);
  for (std::size_t p = 0; p < n; ++p) {
    const int node = node_[p];
    place[static_cast<std::size_t>(node)] = static_cast<int>(p);
    const double mean = block(A, pattern.find(node, node)).trace() / 3.0;
    require(mean > 0.0,
            "fem: the step matrix at the reference positions is not positive definite. Halve "
            "fem.micro_step_s.");
    root_.push_back(std::sqrt(mean));
  }
  column_.reserve(pattern.blocks() - n);
  value_.reserve(9 * (pattern.blocks() - n));
  std::vector<std::pair<int, int>> blocks;  // place of the column, block
  for (std::size_t p = 0; p < n; ++p) {
    const auto i = static_cast<std::size_t>(node_[p]);
    blocks.clear();
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const auto j = static_cast<std::size_t>(pattern.column[static_cast<std::size_t>(b)]);
      blocks.emplace_back(place[j], b);
    }
    std::sort(blocks.begin(), blocks.end());
    Row& row = row_.emplace_back();
    row.first = static_cast<int>(column_.size());
    for (const auto& [j, b] : blocks) {
      const Eigen::Matrix3d value = block(A, b) / (root_[p] * root_[static_cast<std::size_t>(j)]);
      if (j == static_cast<int>(p)) {
        row.middle = static_cast<int>(column_.size());
        invert(value);
        continue;
      }
      column_.push_back(j);
      for (int k = 0; k < 9; ++k) value_.push_back(static_cast<float>(value(k % 3, k / 3)));
    }
  }
  row_.push_back({static_cast<int>(column_.size()), static_cast<int>(column_.size())});
}

/// Appends the inverse of a diagonal block, symmetric to the last bit.
void GaussSeidel::invert(const Eigen::Matrix3d& diagonal) {
  const Eigen::Matrix3d inverse = diagonal.inverse();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3f column =
        (0.5 * (inverse.col(k) + inverse.row(k).transpose())).cast<float>();
    inverse_diagonal_.push_back({{column[0], column[1], column[2], 0.0F}});
  }
}

void GaussSeidel::forward(const Padded4* r, Padded4* x, ThreadTeam& team) const {
  const Matrix A{row_.data(), column_.data(), value_.data(), inverse_diagonal_.data()};
  for (std::size_t c = 0; c + 1 < colour_start_.size(); ++c) {
    const int first = colour_start_[c];
    team.run(colour_start_[c + 1] - first, [&](int t) {
      const auto tile = static_cast<std::size_t>(first + t);
      sweep_forward(A, tile_start_[tile], tile_start_[tile + 1], r, x);
    });
  }
}

void GaussSeidel::residual(const Padded4* x, Padded4* left, ThreadTeam& team) const {
  const Matrix A{row_.data(), column_.data(), value_.data(), inverse_diagonal_.data()};
  team.run(colour_start_.back(), [&](int t) {
    const auto tile = static_cast<std::size_t>(t);
    sweep_residual(A, tile_start_[tile], tile_start_[tile + 1], x, left);
  });
}

void GaussSeidel::backward(const Padded4* r, Padded4* x, ThreadTeam& team) const {
  const Matrix A{row_.data(), column_.data(), value_.data(), inverse_diagonal_.data()};
  for (std::size_t c = colour_start_.size() - 1; c-- > 0;) {
    const int first = colour_start_[c];
    team.run(colour_start_[c + 1] - first, [&](int t) {
      const auto tile = static_cast<std::size_t>(first + t);
      sweep_backward(A, tile_start_[tile], tile_start_[tile + 1], r, x);
    });
  }
}

std::size_t GaussSeidel::bytes() const {
  return sizeof(float) * value_.size() + sizeof(int) * column_.size() + sizeof(Row) * row_.size() +
         sizeof(Padded4) * inverse_diagonal_.size() + (sizeof(int) + sizeof(double)) * node_.size();
}

}  // namespace tandem::fem
