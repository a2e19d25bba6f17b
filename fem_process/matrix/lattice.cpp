#include "fem_process/matrix/lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace tandem::fem {
namespace {

/// Corners of less weight are left out; the error in P is as large.
constexpr double kNoWeight = 1e-9;

/// More than nothing on the diagonal of Pᵀ A P: see Lattice::project.
constexpr double kExcess = 1e-6;

/// Of a lattice node: 21 bits in each direction, the last direction's first.
using Index = std::uint64_t;
Index pack(const std::array<std::uint64_t, 3>& at) { return at[2] << 42 | at[1] << 21 | at[0]; }
Eigen::Vector3d unpack(Index number) {
  constexpr Index kMask = (Index{1} << 21) - 1;
  return {static_cast<double>(number & kMask), static_cast<double>(number >> 21 & kMask),
          static_cast<double>(number >> 42)};
}

void bounds(const std::vector<Eigen::Vector3d>& positions, Eigen::Vector3d& low,
            Eigen::Vector3d& high) {
  low = high = positions.front();
  for (const Eigen::Vector3d& X : positions) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
}

/// The bits of a number below 1024, two zeros between them.
std::uint64_t spread(std::uint64_t number) {
  std::uint64_t wide = 0;
  for (int bit = 0; bit < 10; ++bit) wide |= (number >> bit & 1U) << (3 * bit);
  return wide;
}

}  // namespace

double mean_edge(const BlockPattern& pattern, const std::vector<Eigen::Vector3d>& positions) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const auto j = static_cast<std::size_t>(pattern.column[static_cast<std::size_t>(b)]);
      if (j <= i) continue;
      sum += (positions[j] - positions[i]).norm();
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 1.0;
}

std::vector<int> near_order(const std::vector<Eigen::Vector3d>& positions) {
  std::vector<int> order(positions.size());
  if (positions.empty()) return order;
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  bounds(positions, low, high);
  const double side = std::max((high - low).maxCoeff(), 1e-300);
  std::vector<std::uint64_t> numbers;
  numbers.reserve(positions.size());
  for (const Eigen::Vector3d& X : positions) {
    std::uint64_t number = 0;
    for (int a = 0; a < 3; ++a) {
      const double at = 1024.0 * (X[a] - low[a]) / side;
      number |= spread(static_cast<std::uint64_t>(std::clamp(at, 0.0, 1023.0))) << a;
    }
    numbers.push_back(number);
  }
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return numbers[static_cast<std::size_t>(a)] < numbers[static_cast<std::size_t>(b)];
  });
  return order;
}

Lattice::Lattice(const std::vector<Eigen::Vector3d>& positions, double spacing) {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  bounds(positions, low, high);
  const Eigen::Vector3d extent = high - low;
  const Eigen::Array3d cells = (extent.array() / spacing).round().max(1.0).min(1e6);
  const Eigen::Vector3d side = (extent.array() > 0.0).select(extent.array() / cells, spacing);
  corners_.resize(positions.size());
  std::vector<std::array<Index, 8>> at(positions.size());
  std::vector<Index> used;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Array3d place = (positions[i] - low).cwiseQuotient(side);
    const Eigen::Array3d cell = place.floor().min(cells - 1.0).max(0.0);
    const Eigen::Array3d part = (place - cell).min(1.0).max(0.0);
    for (std::size_t c = 0; c < 8; ++c) {
      double weight = 1.0;
      std::array<std::uint64_t, 3> index{};
      for (std::size_t d = 0; d < 3; ++d) {
        const auto a = static_cast<Eigen::Index>(d);
        const bool far = (c >> d & 1U) != 0;
        weight *= far ? part[a] : 1.0 - part[a];
        index[d] = static_cast<std::uint64_t>(cell[a]) + (far ? 1U : 0U);
      }
      at[i][c] = pack(index);
      corners_[i].weight[c] = weight > kNoWeight ? weight : 0.0;
      if (corners_[i].weight[c] > 0.0) used.push_back(at[i][c]);
    }
  }
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (const Index number : used) positions_.emplace_back(low + unpack(number).cwiseProduct(side));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    int any = 0;
    for (std::size_t c = 0; c < 8; ++c) {
      if (!(corners_[i].weight[c] > 0.0)) continue;
      any = static_cast<int>(std::lower_bound(used.begin(), used.end(), at[i][c]) - used.begin());
      corners_[i].node[c] = any;
    }
    for (std::size_t c = 0; c < 8; ++c) {
      if (!(corners_[i].weight[c] > 0.0)) corners_[i].node[c] = any;
    }
  }
}

namespace {

/// One row of Pᵀ A P: blocks in the order in which they were first met.
class RowSum {
 public:
  explicit RowSum(std::size_t columns) : slot_(columns, -1) {}

  void add(int column, double factor, const double* block) {
    int& slot = slot_[static_cast<std::size_t>(column)];
    if (slot < 0) {
      slot = static_cast<int>(columns_.size());
      columns_.push_back(column);
      sums_.resize(sums_.size() + 9, 0.0);
    }
    double* const to = sums_.data() + 9 * static_cast<std::ptrdiff_t>(slot);
    for (int k = 0; k < 9; ++k) to[k] += factor * block[k];
  }

  /// Appends the row to a matrix, and begins anew.
  void finish(BlockPattern& pattern, BlockValues& A) {
    std::sort(columns_.begin(), columns_.end());
    for (int column : columns_) {
      int& slot = slot_[static_cast<std::size_t>(column)];
      const auto from = sums_.begin() + 9 * static_cast<std::ptrdiff_t>(slot);
      A.insert(A.end(), from, from + 9);
      pattern.column.push_back(column);
      slot = -1;
    }
    pattern.row_start.push_back(static_cast<int>(pattern.column.size()));
    columns_.clear();
    sums_.clear();
  }

 private:
  std::vector<int> slot_;
  std::vector<int> columns_;
  BlockValues sums_;
};

}  // namespace

void Lattice::project(const BlockPattern& pattern, const BlockValues& A,
                      BlockPattern& coarse_pattern, BlockValues& coarse_A) const {
  std::vector<std::vector<std::pair<int, double>>> hangs(positions_.size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    for (std::size_t c = 0; c < 8; ++c) {
      const double weight = corners_[i].weight[c];
      const auto node = static_cast<std::size_t>(corners_[i].node[c]);
      if (weight > 0.0) hangs[node].emplace_back(static_cast<int>(i), weight);
    }
  }
  coarse_pattern = {};
  coarse_A.clear();
  RowSum sum(positions_.size());
  for (const auto& list : hangs) {
    for (const auto& [i, weight] : list) {
      const auto row = static_cast<std::size_t>(i);
      for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
        const auto j = static_cast<std::size_t>(pattern.column[static_cast<std::size_t>(b)]);
        for (std::size_t c = 0; c < 8; ++c) {
          const double factor = weight * corners_[j].weight[c];
          const double* const values = A.data() + 9 * static_cast<std::ptrdiff_t>(b);
          if (factor > 0.0) sum.add(corners_[j].node[c], factor, values);
        }
      }
    }
    sum.finish(coarse_pattern, coarse_A);
  }
  for (int a = 0; a < coarse_pattern.rows(); ++a) {
    block(coarse_A, coarse_pattern.find(a, a)) *= 1.0 + kExcess;
  }
}

}  // namespace tandem::fem
