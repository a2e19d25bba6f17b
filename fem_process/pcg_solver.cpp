#include "fem_process/pcg_solver.h"

#include <Eigen/Dense>
#include <cstdio>

namespace tandem::fem {
namespace {

std::string text(const char* format, double a, double b, int n) {
  char buffer[200];
  std::snprintf(buffer, sizeof buffer, format, a, b, n);
  return buffer;
}

}  // namespace

PcgSolver::PcgSolver(const SolverParams& params, const BlockPattern& pattern)
    : params_(params), pattern_(pattern) {}

SolveReport PcgSolver::factorize(const BlockValues& A) {
  A_ = A;
  inverse_diagonal_.resize(9 * static_cast<std::size_t>(pattern_.rows()));
  for (int i = 0; i < pattern_.rows(); ++i) {
    const Eigen::Matrix3d diagonal = block(A_, pattern_.find(i, i));
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

SolveReport PcgSolver::solve_column(Eigen::VectorXd& r, double b_norm) const {
  const double limit = params_.tolerance * b_norm;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(r.size());
  Eigen::VectorXd z = precondition(r);
  Eigen::VectorXd p = z;
  double rz = r.dot(z);
  double residual = r.norm();
  SolveReport report;
  while (residual > limit && report.iterations < params_.max_iterations) {
    const Eigen::VectorXd Ap = multiply(pattern_, A_, p);
    const double curvature = p.dot(Ap);
    if (!(curvature > 0.0)) {
      return {.outcome = Outcome::Failed,
              .message = "the step matrix is not positive definite. Halve fem.micro_step_s.",
              .iterations = report.iterations};
    }
    const double alpha = rz / curvature;
    x += alpha * p;
    r -= alpha * Ap;
    residual = r.norm();
    z = precondition(r);
    const double rz_next = r.dot(z);
    p = z + (rz_next / rz) * p;
    rz = rz_next;
    ++report.iterations;
  }
  if (!(residual <= limit)) {
    report.outcome = Outcome::NotConverged;
    report.message = text("PCG: residual %.3g N, limit %.3g N after %d iterations. ", residual,
                          limit, report.iterations) +
                     "Raise fem.solver.max_iterations or use fem.solver.kind: cholmod.";
  }
  r = x;
  return report;
}

Eigen::VectorXd PcgSolver::precondition(const Eigen::VectorXd& r) const {
  Eigen::VectorXd z(r.size());
  for (int i = 0; i < pattern_.rows(); ++i) {
    z.segment<3>(3 * i) = block(inverse_diagonal_, i) * r.segment<3>(3 * i);
  }
  return z;
}

}  // namespace tandem::fem
