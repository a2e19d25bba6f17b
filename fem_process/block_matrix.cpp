#include "fem_process/block_matrix.h"

#include <algorithm>

namespace tandem::fem {

int BlockPattern::find(int i, int j) const {
  const auto begin = column.begin() + row_start[static_cast<std::size_t>(i)];
  const auto end = column.begin() + row_start[static_cast<std::size_t>(i) + 1];
  return static_cast<int>(std::lower_bound(begin, end, j) - column.begin());
}

BlockPattern pattern_of(const TetMesh& mesh) {
  std::vector<std::vector<int>> neighbours(mesh.X.size());
  for (const Tet& tet : mesh.tets) {
    for (int i : tet) {
      auto& row = neighbours[static_cast<std::size_t>(i)];
      row.insert(row.end(), tet.begin(), tet.end());
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

Eigen::VectorXd multiply(const BlockPattern& pattern, const BlockValues& values,
                         const Eigen::VectorXd& x) {
  Eigen::VectorXd y(x.size());
  for (int i = 0; i < pattern.rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
      sum += block(values, b) * x.segment<3>(3 * pattern.column[static_cast<std::size_t>(b)]);
    }
    y.segment<3>(3 * i) = sum;
  }
  return y;
}

Eigen::VectorXd multiply_scalar(const BlockPattern& pattern, const std::vector<double>& values,
                                const Eigen::VectorXd& x) {
  Eigen::VectorXd y(x.size());
  for (int i = 0; i < pattern.rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
      const auto at = static_cast<std::size_t>(b);
      sum += values[at] * x.segment<3>(3 * pattern.column[at]);
    }
    y.segment<3>(3 * i) = sum;
  }
  return y;
}

}  // namespace tandem::fem
