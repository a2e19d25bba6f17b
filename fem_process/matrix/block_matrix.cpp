#include "fem_process/matrix/block_matrix.h"

#include <algorithm>

#include "fem_process/kernels/simd.h"
#include "fem_process/matrix/node_vectors.h"

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

/// Rows that a thread takes at a time.
constexpr std::size_t kGrain = 256;

/// Four lanes that begin with each row of a block meet x_j; the last row is read with the number
/// before it, so that nothing behind the block is touched. Idle lanes are thrown away.
TANDEM_INLINE void multiply_rows_body(const int* row_start, const int* column, const double* values,
                                      const Padded* x, Padded* y, std::size_t begin,
                                      std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    Double4 sum[3] = {};
    for (int b = row_start[i]; b < row_start[i + 1]; ++b) {
      const double* block = values + 9 * static_cast<std::ptrdiff_t>(b);
      Double4 x_j;
      Double4 a[3];
      load(x_j, x[column[b]].at);
      load(a[0], block);
      load(a[1], block + 3);
      load(a[2], block + 5);
      sum[0] += a[0] * x_j;
      sum[1] += a[1] * x_j;
      sum[2] += a[2] * __builtin_shufflevector(x_j, x_j, 3, 0, 1, 2);
    }
    sum[2] = __builtin_shufflevector(sum[2], sum[2], 1, 2, 3, 0);
    Double4 idle{};
    transpose(sum[0], sum[1], sum[2], idle);
    const Double4 y_i = sum[0] + sum[1] + sum[2];
    store(y_i, y[i].at);
  }
}

TANDEM_VECTOR_FUNCTION(multiply_block_rows, multiply_rows_body,
                       (const int* row_start, const int* column, const double* values,
                        const Padded* x, Padded* y, std::size_t begin, std::size_t end),
                       (row_start, column, values, x, y, begin, end))

TANDEM_INLINE void multiply_number_rows_body(const int* row_start, const int* column,
                                             const double* values, const Padded* x, Padded* y,
                                             std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    Double4 sum{};
    for (int b = row_start[i]; b < row_start[i + 1]; ++b) {
      Double4 x_j;
      load(x_j, x[column[b]].at);
      sum += values[b] * x_j;
    }
    store(sum, y[i].at);
  }
}

TANDEM_VECTOR_FUNCTION(multiply_number_rows, multiply_number_rows_body,
                       (const int* row_start, const int* column, const double* values,
                        const Padded* x, Padded* y, std::size_t begin, std::size_t end),
                       (row_start, column, values, x, y, begin, end))

template <class Registers>
TANDEM_INLINE void multiply_eight_body(const BlockPattern& pattern, const double* values,
                                       const double* X, double* Y, std::size_t begin,
                                       std::size_t end) {
  using Lanes = typename Registers::Double8;
  for (std::size_t i = begin; i < end; ++i) {
    Lanes sum[3] = {};
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const double* A = values + 9 * static_cast<std::ptrdiff_t>(b);
      const double* x_j =
          X + 24 * static_cast<std::ptrdiff_t>(pattern.column[static_cast<std::size_t>(b)]);
      Lanes x[3];
      for (int k = 0; k < 3; ++k) load(x[k], x_j + 8 * k);
      for (int r = 0; r < 3; ++r) {
        sum[r] += A[3 * r] * x[0] + A[3 * r + 1] * x[1] + A[3 * r + 2] * x[2];
      }
    }
    for (std::size_t k = 0; k < 3; ++k) store(sum[k], Y + 24 * i + 8 * k);
  }
}

TANDEM_REGISTER_FUNCTION(multiply_eight_rows, multiply_eight_body,
                         (const BlockPattern& pattern, const double* values, const double* X,
                          double* Y, std::size_t begin, std::size_t end),
                         (pattern, values, X, Y, begin, end))

}  // namespace

void multiply_rows(const BlockPattern& pattern, const BlockValues& values, const Padded* x,
                   Padded* y, std::size_t begin, std::size_t end) {
  multiply_block_rows(pattern.row_start.data(), pattern.column.data(), values.data(), x, y, begin,
                      end);
}

Eigen::VectorXd multiply(const BlockPattern& pattern, const BlockValues& values,
                         const Eigen::VectorXd& x, ProductPart part, ThreadTeam* team) {
  const auto rows = static_cast<std::size_t>(pattern.rows());
  // Kept between calls: fresh memory costs more than the arithmetic.
  static thread_local std::vector<Padded> in;
  static thread_local std::vector<Padded> out;
  pad(x, in);
  if (part.rows != nullptr) {
    out.assign(rows, Padded{});
    for (int i : *part.rows) {
      const auto row = static_cast<std::size_t>(i);
      multiply_rows(pattern, values, in.data(), out.data(), row, row + 1);
    }
  } else {
    ThreadTeam alone;
    out.resize(rows);
    // Helpers have thread-local vectors of their own.
    const Padded* const from = in.data();
    Padded* const to = out.data();
    (team != nullptr ? *team : alone)
        .run_ranges(rows, kGrain, [&](std::size_t begin, std::size_t end) {
          multiply_rows(pattern, values, from, to, begin, end);
        });
  }
  Eigen::VectorXd y;
  unpad(out, y);
  return y;
}

void multiply_eight(const BlockPattern& pattern, const BlockValues& values, const EightVectors& X,
                    EightVectors& Y, ThreadTeam& team) {
  Y.resize(8, X.cols());
  team.run_ranges(static_cast<std::size_t>(pattern.rows()), kGrain,
                  [&](std::size_t begin, std::size_t end) {
                    multiply_eight_rows(pattern, values.data(), X.data(), Y.data(), begin, end);
                  });
}

Eigen::MatrixXd multiply_columns(const BlockPattern& pattern, const BlockValues& values,
                                 const Eigen::MatrixXd& X, ThreadTeam& team) {
  Eigen::MatrixXd Y(X.rows(), X.cols());
  EightVectors in;
  EightVectors out;
  for (Eigen::Index c = 0; c < X.cols(); c += 8) {
    const Eigen::Index count = std::min<Eigen::Index>(8, X.cols() - c);
    in.setZero(8, X.rows());
    in.topRows(count) = X.middleCols(c, count).transpose();
    multiply_eight(pattern, values, in, out, team);
    Y.middleCols(c, count) = out.topRows(count).transpose();
  }
  return Y;
}

Eigen::VectorXd multiply_scalar(const BlockPattern& pattern, const std::vector<double>& values,
                                const Eigen::VectorXd& x, ProductPart part) {
  const auto rows = static_cast<std::size_t>(pattern.rows());
  static thread_local std::vector<Padded> in;
  static thread_local std::vector<Padded> out;
  pad(x, in);
  out.resize(rows);
  const auto sum_rows = [&](std::size_t begin, std::size_t end) {
    multiply_number_rows(pattern.row_start.data(), pattern.column.data(), values.data(), in.data(),
                         out.data(), begin, end);
  };
  if (part.rows != nullptr) {
    out.assign(rows, Padded{});
    for (int i : *part.rows) sum_rows(static_cast<std::size_t>(i), static_cast<std::size_t>(i) + 1);
  } else {
    sum_rows(0, rows);
  }
  Eigen::VectorXd y;
  unpad(out, y);
  return y;
}

}  // namespace tandem::fem
