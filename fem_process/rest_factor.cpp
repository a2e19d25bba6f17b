#include "fem_process/rest_factor.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cstring>

#include "fem_process/cholmod_solver.h"
#include "fem_process/simd.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));

TANDEM_INLINE void load(Lanes& lanes, const float* from) {
  std::memcpy(&lanes, from, sizeof lanes);
}
TANDEM_INLINE void store(const Lanes& lanes, float* to) { std::memcpy(to, &lanes, sizeof lanes); }

/// out = P x, P by columns `padded` apart, N vectors of rows at a time.
template <int N>
TANDEM_INLINE void multiply_rows(const float* P, int padded, int columns, const float* x,
                                 float* out) {
  Lanes sum[N] = {};
  for (int k = 0; k < columns; ++k) {
    for (int n = 0; n < N; ++n) {
      Lanes a;
      load(a, P + static_cast<std::ptrdiff_t>(k) * padded + n * kLanes);
      sum[n] += a * x[k];
    }
  }
  for (int n = 0; n < N; ++n) store(sum[n], out + n * kLanes);
}

TANDEM_INLINE void multiply_body(const float* P, int padded, int columns, const float* x,
                                 float* out) {
  int i = 0;
  for (; i + 4 * kLanes <= padded; i += 4 * kLanes)
    multiply_rows<4>(P + i, padded, columns, x, out + i);
  for (; i < padded; i += kLanes) multiply_rows<1>(P + i, padded, columns, x, out + i);
}

/// N entries of Pᵀ x: lane sums, then across the lanes in fixed order.
template <int N>
TANDEM_INLINE void multiply_columns(const float* P, int padded, const float* x, float* out) {
  Lanes sum[N] = {};
  for (int i = 0; i < padded; i += kLanes) {
    Lanes b;
    load(b, x + i);
    for (int n = 0; n < N; ++n) {
      Lanes a;
      load(a, P + static_cast<std::ptrdiff_t>(n) * padded + i);
      sum[n] += a * b;
    }
  }
  for (int n = 0; n < N; ++n) {
    const Lanes& s = sum[n];
    out[n] = ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
  }
}

TANDEM_INLINE void multiply_transposed_body(const float* P, int padded, int columns, const float* x,
                                            float* out) {
  int k = 0;
  for (; k + 4 <= columns; k += 4) {
    multiply_columns<4>(P + static_cast<std::ptrdiff_t>(k) * padded, padded, x, out + k);
  }
  for (; k < columns; ++k) {
    multiply_columns<1>(P + static_cast<std::ptrdiff_t>(k) * padded, padded, x, out + k);
  }
}

TANDEM_VECTOR_FUNCTION(multiply, multiply_body,
                       (const float* P, int padded, int columns, const float* x, float* out),
                       (P, padded, columns, x, out))
TANDEM_VECTOR_FUNCTION(multiply_transposed, multiply_transposed_body,
                       (const float* P, int padded, int columns, const float* x, float* out),
                       (P, padded, columns, x, out))

}  // namespace

RestFactor::RestFactor(const BlockPattern& pattern, const BlockValues& A) {
  CholmodSolver solver(pattern);
  const SolveReport report = solver.factorize(A);
  require(report.outcome == Outcome::Done,
          "fem: the preconditioner rest_factor: at the reference positions " + report.message);
  const SupernodalFactor factor = solver.factor();
  permutation_ = factor.permutation;
  row_ = factor.row;
  for (int s = 0; s < factor.supernodes(); ++s) add_panel(factor, s);
}

void RestFactor::add_panel(const SupernodalFactor& factor, int s) {
  const auto at = static_cast<std::size_t>(s);
  Panel panel;
  panel.first_column = factor.first_column[at];
  panel.columns = factor.first_column[at + 1] - panel.first_column;
  panel.rows = factor.row_start[at + 1] - factor.row_start[at];
  panel.padded = (panel.rows + kLanes - 1) / kLanes * kLanes;
  panel.row_start = factor.row_start[at] + panel.columns;
  panel.value = value_.size();
  const Eigen::Map<const Eigen::MatrixXd> L(factor.value.data() + factor.value_start[at],
                                            panel.rows, panel.columns);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(panel.padded, panel.columns);
  P.topRows(panel.columns) = L.topRows(panel.columns)
                                 .triangularView<Eigen::Lower>()
                                 .solve(Eigen::MatrixXd::Identity(panel.columns, panel.columns));
  const int below = panel.rows - panel.columns;
  P.middleRows(panel.columns, below).noalias() = -L.bottomRows(below) * P.topRows(panel.columns);
  value_.resize(panel.value + static_cast<std::size_t>(P.size()));
  Eigen::Map<Eigen::MatrixXf>(value_.data() + panel.value, P.rows(), P.cols()) = P.cast<float>();
  most_rows_ = std::max(most_rows_, panel.padded);
  panels_.push_back(panel);
}

/// y ← L⁻ᵀ L⁻¹ y. The rows below a supernode's columns, which its product changes (forwards) or
/// needs (backwards), are gathered beside the columns.
void RestFactor::run(Scratch& scratch) const {
  float* y = scratch.y.data();
  float* rows = scratch.rows.data();
  for (const Panel& panel : panels_) {
    multiply(value_.data() + panel.value, panel.padded, panel.columns, y + panel.first_column,
             rows);
    std::copy(rows, rows + panel.columns, y + panel.first_column);
    const int* row = row_.data() + panel.row_start;
    for (int i = panel.columns; i < panel.rows; ++i) y[row[i - panel.columns]] += rows[i];
  }
  for (auto panel = panels_.rbegin(); panel != panels_.rend(); ++panel) {
    const int* row = row_.data() + panel->row_start;
    std::copy(y + panel->first_column, y + panel->first_column + panel->columns, rows);
    for (int i = panel->columns; i < panel->rows; ++i) rows[i] = y[row[i - panel->columns]];
    std::fill(rows + panel->rows, rows + panel->padded, 0.0F);
    multiply_transposed(value_.data() + panel->value, panel->padded, panel->columns, rows,
                        y + panel->first_column);
  }
}

void RestFactor::solve(const Eigen::VectorXd& r, Eigen::VectorXd& z, Scratch& scratch) const {
  const auto n = permutation_.size();
  scratch.y.resize(n);
  scratch.rows.resize(static_cast<std::size_t>(most_rows_));
  // Scaled, so that small residuals do not underflow.
  const double size = r.norm();
  const double scale = size > 0.0 ? 1.0 / size : 1.0;
  for (std::size_t i = 0; i < n; ++i) {
    scratch.y[i] = static_cast<float>(scale * r[permutation_[i]]);
  }
  run(scratch);
  for (std::size_t i = 0; i < n; ++i) {
    z[permutation_[i]] = size * static_cast<double>(scratch.y[i]);
  }
}

}  // namespace tandem::fem
