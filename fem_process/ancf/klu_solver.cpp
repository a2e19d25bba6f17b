#include "fem_process/ancf/klu_solver.h"

#include <klu.h>

#include <algorithm>

#include "protocol/contract/error.h"

namespace tandem::fem::ancf {

int ColumnPattern::find(int row_index, int column) const {
  const auto begin = row.begin() + column_start[static_cast<std::size_t>(column)];
  const auto end = row.begin() + column_start[static_cast<std::size_t>(column) + 1];
  return static_cast<int>(std::lower_bound(begin, end, row_index) - row.begin());
}

Eigen::MatrixXd ColumnPattern::times(const std::vector<double>& values,
                                     const Eigen::MatrixXd& X) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(size, X.cols());
  for (int j = 0; j < size; ++j) {
    const auto at = static_cast<std::size_t>(j);
    for (int p = column_start[at]; p < column_start[at + 1]; ++p) {
      const auto entry = static_cast<std::size_t>(p);
      product.row(row[entry]) += values[entry] * X.row(j);
    }
  }
  return product;
}

Eigen::MatrixXd ColumnPattern::transposed_times(const std::vector<double>& values,
                                                const Eigen::MatrixXd& X) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(size, X.cols());
  for (int j = 0; j < size; ++j) {
    const auto at = static_cast<std::size_t>(j);
    for (int p = column_start[at]; p < column_start[at + 1]; ++p) {
      const auto entry = static_cast<std::size_t>(p);
      product.row(j) += values[entry] * X.row(row[entry]);
    }
  }
  return product;
}

struct KluSymbolic {
  klu_common common{};
  klu_symbolic* symbolic = nullptr;

  KluSymbolic() = default;
  KluSymbolic(const KluSymbolic&) = delete;
  KluSymbolic& operator=(const KluSymbolic&) = delete;
  ~KluSymbolic() { klu_free_symbolic(&symbolic, &common); }
};

struct KluNumeric {
  std::shared_ptr<KluSymbolic> symbolic;
  klu_common common{};
  klu_numeric* numeric = nullptr;
  int size = 0;

  KluNumeric() = default;
  KluNumeric(const KluNumeric&) = delete;
  KluNumeric& operator=(const KluNumeric&) = delete;
  ~KluNumeric() { klu_free_numeric(&numeric, &common); }
};

KluSolver::KluSolver(ColumnPattern pattern)
    : pattern_(std::make_shared<const ColumnPattern>(std::move(pattern))),
      symbolic_(std::make_shared<KluSymbolic>()) {
  klu_defaults(&symbolic_->common);
  // One connected structure: there is no block triangular form to look for.
  symbolic_->common.btf = 0;
  auto* start = const_cast<int*>(pattern_->column_start.data());
  auto* row = const_cast<int*>(pattern_->row.data());
  symbolic_->symbolic = klu_analyze(pattern_->size, start, row, &symbolic_->common);
  require(symbolic_->symbolic != nullptr, "fem: KLU cannot analyse the pattern of the beams.");
}

std::shared_ptr<const LuFactor> KluSolver::factorize(std::vector<double>& values) const {
  auto klu = std::make_shared<KluNumeric>();
  klu->symbolic = symbolic_;
  klu->common = symbolic_->common;
  klu->size = pattern_->size;
  auto* start = const_cast<int*>(pattern_->column_start.data());
  auto* row = const_cast<int*>(pattern_->row.data());
  klu->numeric = klu_factor(start, row, values.data(), symbolic_->symbolic, &klu->common);
  const bool usable = klu->numeric != nullptr && klu->common.status == KLU_OK &&
                      klu_rcond(symbolic_->symbolic, klu->numeric, &klu->common) != 0 &&
                      klu->common.rcond > 0.0;
  if (!usable) return nullptr;
  auto factor = std::make_shared<LuFactor>();
  factor->klu_ = std::move(klu);
  return factor;
}

void LuFactor::solve(Eigen::VectorXd& b) const {
  klu_common common = klu_->common;
  klu_solve(klu_->symbolic->symbolic, klu_->numeric, klu_->size, 1, b.data(), &common);
}

void LuFactor::solve_transposed(Eigen::MatrixXd& B) const {
  klu_common common = klu_->common;
  klu_tsolve(klu_->symbolic->symbolic, klu_->numeric, klu_->size, static_cast<int>(B.cols()),
             B.data(), &common);
}

}  // namespace tandem::fem::ancf
