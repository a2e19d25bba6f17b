#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace tandem::fem::ancf {

/// Constant pattern of a sparse square matrix, compressed columns with sorted rows.
struct ColumnPattern {
  int size = 0;
  std::vector<int> column_start;  ///< size + 1
  std::vector<int> row;
  [[nodiscard]] std::size_t entries() const { return row.size(); }
  /// Index of an entry that is in the pattern.
  [[nodiscard]] int find(int row_index, int column) const;
  /// A X and Aᵀ X of the matrix with these values.
  [[nodiscard]] Eigen::MatrixXd times(const std::vector<double>& values,
                                      const Eigen::MatrixXd& X) const;
  [[nodiscard]] Eigen::MatrixXd transposed_times(const std::vector<double>& values,
                                                 const Eigen::MatrixXd& X) const;
};

struct KluSymbolic;
struct KluNumeric;

/// LU factors of a general matrix. Never changes: it may be shared between states.
class LuFactor {
 public:
  /// Overwrites b with A⁻¹ b.
  void solve(Eigen::VectorXd& b) const;
  /// Overwrites the columns of B with A⁻ᵀ B.
  void solve_transposed(Eigen::MatrixXd& B) const;

 private:
  friend class KluSolver;
  std::shared_ptr<const KluNumeric> klu_;
};

/// Sparse direct solver for unsymmetric matrices of one pattern [KLU, Davis & Palamadai 2010]:
/// ordering and symbolic analysis once, then numeric factorisations. Single-threaded and
/// deterministic: a factor depends on the values alone, not on what was factorised before.
class KluSolver {
 public:
  explicit KluSolver(ColumnPattern pattern);

  /// Null when the matrix is singular to working precision or not finite.
  [[nodiscard]] std::shared_ptr<const LuFactor> factorize(std::vector<double>& values) const;
  [[nodiscard]] const ColumnPattern& pattern() const { return *pattern_; }

 private:
  std::shared_ptr<const ColumnPattern> pattern_;
  std::shared_ptr<KluSymbolic> symbolic_;
};

}  // namespace tandem::fem::ancf
