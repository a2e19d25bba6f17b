#include "fem_process/pcg_solver.h"

#include <Eigen/Dense>
#include <cstdio>
#include <cstring>

#include "fem_process/simd.h"

namespace tandem::fem {
namespace {

std::string text(const char* format, double a, double b, int n) {
  char buffer[200];
  std::snprintf(buffer, sizeof buffer, format, a, b, n);
  return buffer;
}

using Lanes = double __attribute__((vector_size(4 * sizeof(double))));

/// y = A x: `columns` holds the blocks by columns, and one number more. The fourth lane is idle: it
/// computes with the next column's first entry and is thrown away.
TANDEM_INLINE void multiply_body(const BlockPattern& pattern, const double* columns,
                                 const double* x, double* y) {
  for (std::size_t i = 0; i < pattern.row_start.size() - 1; ++i) {
    Lanes sum{};
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const double* block = columns + 9 * static_cast<std::ptrdiff_t>(b);
      const double* x_j =
          x + 3 * static_cast<std::ptrdiff_t>(pattern.column[static_cast<std::size_t>(b)]);
      Lanes a[3];
      for (int k = 0; k < 3; ++k) std::memcpy(&a[k], block + 3 * k, sizeof a[k]);
      sum += a[0] * x_j[0] + a[1] * x_j[1] + a[2] * x_j[2];
    }
    for (int k = 0; k < 3; ++k) y[3 * i + static_cast<std::size_t>(k)] = sum[k];
  }
}

TANDEM_VECTOR_FUNCTION(multiply_columns, multiply_body,
                       (const BlockPattern& pattern, const double* columns, const double* x,
                        double* y),
                       (pattern, columns, x, y))

}  // namespace

PcgSolver::PcgSolver(const SolverParams& params, const BlockPattern& pattern,
                     const RestFactor* rest)
    : params_(params), pattern_(pattern), rest_(rest) {
  if (rest_ == nullptr) params_.preconditioner = PreconditionerKind::BlockJacobi;
}

SolveReport PcgSolver::factorize(const BlockValues& A,
                                 const std::vector<Eigen::Matrix3d>& rotations) {
  columns_.resize(A.size() + 1);
  for (std::size_t b = 0; b < A.size(); b += 9) {
    for (std::size_t k = 0; k < 9; ++k) columns_[b + 3 * (k % 3) + k / 3] = A[b + k];
  }
  rotations_.clear();
  if (params_.preconditioner == PreconditionerKind::BlockJacobi) return invert_diagonal(A);
  if (params_.preconditioner == PreconditionerKind::WarpedRestFactor) rotations_ = rotations;
  return {};
}

SolveReport PcgSolver::invert_diagonal(const BlockValues& A) {
  inverse_diagonal_.resize(9 * static_cast<std::size_t>(pattern_.rows()));
  for (int i = 0; i < pattern_.rows(); ++i) {
    const Eigen::Matrix3d diagonal = block(A, pattern_.find(i, i));
    const Eigen::LLT<Eigen::Matrix3d> llt(diagonal);
    if (llt.info() != Eigen::Success) {
      return {.outcome = Outcome::Failed,
              .message = "the step matrix is not positive definite. Halve fem.micro_step_s."};
    }
    block(inverse_diagonal_, i) = llt.solve(Eigen::Matrix3d::Identity());
  }
  return {};
}

SolveReport PcgSolver::solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) {
  SolveReport total;
  for (Eigen::Index column = 0; column < r.cols(); ++column) {
    Eigen::VectorXd x = r.col(column);
    const SolveReport report = solve_column(x, b_norms(column));
    r.col(column) = x;
    total.iterations += report.iterations;
    if (report.outcome > total.outcome) {
      total.outcome = report.outcome;
      total.message = report.message;
    }
  }
  return total;
}

SolveReport PcgSolver::solve_column(Eigen::VectorXd& r, double b_norm) {
  const double limit = params_.tolerance * b_norm;
  double residual = r.norm();
  x_.setZero(r.size());
  SolveReport report;
  double rz = 0.0;
  while (residual > limit && report.iterations < params_.max_iterations) {
    precondition(r);
    const double rz_next = r.dot(z_);
    if (report.iterations == 0) {
      p_ = z_;
    } else {
      p_ = z_ + (rz_next / rz) * p_;
    }
    rz = rz_next;
    Ap_.resize(r.size());
    multiply_columns(pattern_, columns_.data(), p_.data(), Ap_.data());
    const double curvature = p_.dot(Ap_);
    if (!(curvature > 0.0)) {
      return {.outcome = Outcome::Failed,
              .message = "the step matrix is not positive definite. Halve fem.micro_step_s.",
              .iterations = report.iterations};
    }
    const double alpha = rz / curvature;
    x_ += alpha * p_;
    r -= alpha * Ap_;
    residual = r.norm();
    ++report.iterations;
  }
  if (!(residual <= limit)) {
    report.outcome = Outcome::NotConverged;
    report.message = text("PCG: residual %.3g N, limit %.3g N after %d iterations. ", residual,
                          limit, report.iterations) +
                     "Raise fem.solver.max_iterations or use fem.solver.kind: cholmod.";
  }
  r = x_;
  return report;
}

void PcgSolver::precondition(const Eigen::VectorXd& r) {
  z_.resize(r.size());
  if (params_.preconditioner == PreconditionerKind::BlockJacobi) {
    for (int i = 0; i < pattern_.rows(); ++i) {
      z_.segment<3>(3 * i) = block(inverse_diagonal_, i) * r.segment<3>(3 * i);
    }
    return;
  }
  if (rotations_.empty()) return rest_->solve(r, z_, scratch_);
  turned_.resize(r.size());
  for (int i = 0; i < pattern_.rows(); ++i) {
    turned_.segment<3>(3 * i) =
        rotations_[static_cast<std::size_t>(i)].transpose() * r.segment<3>(3 * i);
  }
  rest_->solve(turned_, z_, scratch_);
  for (int i = 0; i < pattern_.rows(); ++i) {
    z_.segment<3>(3 * i) = rotations_[static_cast<std::size_t>(i)] * z_.segment<3>(3 * i).eval();
  }
}

}  // namespace tandem::fem
