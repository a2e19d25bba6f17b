#include "fem_process/block_matrix.h"

#include <algorithm>
#include <cstring>

#include "fem_process/simd.h"

namespace tandem::fem {

int BlockPattern::find(int i, int j) const {
  const auto begin = column.begin() + row_start[static_cast<std::size_t>(i)];
  const auto end = column.begin() + row_start[static_cast<std::size_t>(i) + 1];
  return static_cast<int>(std::lower_bound(begin, end, j) - column.begin());
}

BlockPattern pattern_of(const TetMesh& mesh) {
  std::vector<std::vector<int>> neighbours(mesh.X.size());
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const std::vector<int> nodes = mesh.element(e);
    for (int i : nodes) {
      auto& row = neighbours[static_cast<std::size_t>(i)];
      row.insert(row.end(), nodes.begin(), nodes.end());
    }
  }
  BlockPattern pattern;
  for (auto& row : neighbours) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    pattern.column.insert(pattern.column.end(), row.begin(), row.end());
    pattern.row_start.push_back(static_cast<int>(pattern.column.size()));
  }
  return pattern;
}

SubPattern sub_pattern(const BlockPattern& whole, const std::vector<int>& kept) {
  std::vector<int> number(static_cast<std::size_t>(whole.rows()), -1);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    number[static_cast<std::size_t>(kept[k])] = static_cast<int>(k);
  }
  SubPattern part;
  for (int i : kept) {
    const auto row = static_cast<std::size_t>(i);
    for (int b = whole.row_start[row]; b < whole.row_start[row + 1]; ++b) {
      const int j = number[static_cast<std::size_t>(whole.column[static_cast<std::size_t>(b)])];
      if (j < 0) continue;
      part.pattern.column.push_back(j);
      part.source.push_back(b);
    }
    part.pattern.row_start.push_back(static_cast<int>(part.pattern.column.size()));
  }
  return part;
}

namespace {

/// y = A x or a part of it; `entry(b)` is block b, 3 × 3 or a number.
template <class Entry, class TransposedEntry>
Eigen::VectorXd product(const BlockPattern& pattern, const Eigen::VectorXd& x, ProductPart part,
                        const Entry& entry, const TransposedEntry& transposed) {
  Eigen::VectorXd y(x.size());
  const auto sum_row = [&](int i) {
    const auto row = static_cast<std::size_t>(i);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
      sum += entry(b) * x.segment<3>(3 * pattern.column[static_cast<std::size_t>(b)]);
    }
    y.segment<3>(3 * i) = sum;
  };
  if (part.columns != nullptr) {
    y.setZero();
    for (int j : *part.columns) {
      const auto row = static_cast<std::size_t>(j);
      const Eigen::Vector3d x_j = x.segment<3>(3 * j);
      for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
        y.segment<3>(3 * pattern.column[static_cast<std::size_t>(b)]) += transposed(b) * x_j;
      }
    }
  } else if (part.rows != nullptr) {
    y.setZero();
    for (int i : *part.rows) sum_row(i);
  } else {
    for (int i = 0; i < pattern.rows(); ++i) sum_row(i);
  }
  return y;
}

using Lanes = double __attribute__((vector_size(4 * sizeof(double))));

TANDEM_INLINE void multiply_eight_body(const BlockPattern& pattern, const double* values,
                                       const double* X, double* Y) {
  for (std::size_t i = 0; i + 1 < pattern.row_start.size(); ++i) {
    Lanes sum[6] = {};
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const double* A = values + 9 * static_cast<std::ptrdiff_t>(b);
      const double* x_j =
          X + 24 * static_cast<std::ptrdiff_t>(pattern.column[static_cast<std::size_t>(b)]);
      Lanes x[6];
      for (int k = 0; k < 6; ++k) std::memcpy(&x[k], x_j + 4 * k, sizeof x[k]);
      for (int r = 0; r < 3; ++r) {
        for (int half = 0; half < 2; ++half) {
          sum[2 * r + half] +=
              A[3 * r] * x[half] + A[3 * r + 1] * x[2 + half] + A[3 * r + 2] * x[4 + half];
        }
      }
    }
    for (std::size_t k = 0; k < 6; ++k) std::memcpy(Y + 24 * i + 4 * k, &sum[k], sizeof sum[k]);
  }
}

TANDEM_VECTOR_FUNCTION(multiply_eight_vectors, multiply_eight_body,
                       (const BlockPattern& pattern, const double* values, const double* X,
                        double* Y),
                       (pattern, values, X, Y))

}  // namespace

Eigen::VectorXd multiply(const BlockPattern& pattern, const BlockValues& values,
                         const Eigen::VectorXd& x, ProductPart part) {
  return product(
      pattern, x, part, [&](int b) { return block(values, b); },
      [&](int b) { return block(values, b).transpose(); });
}

EightVectors multiply_eight(const BlockPattern& pattern, const BlockValues& values,
                            const EightVectors& X) {
  EightVectors Y(8, X.cols());
  multiply_eight_vectors(pattern, values.data(), X.data(), Y.data());
  return Y;
}

Eigen::VectorXd multiply_scalar(const BlockPattern& pattern, const std::vector<double>& values,
                                const Eigen::VectorXd& x, ProductPart part) {
  const auto entry = [&](int b) { return values[static_cast<std::size_t>(b)]; };
  return product(pattern, x, part, entry, entry);
}

}  // namespace tandem::fem
