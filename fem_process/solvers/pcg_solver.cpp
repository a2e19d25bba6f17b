#include "fem_process/solvers/pcg_solver.h"

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "fem_process/kernels/simd.h"
#include "fem_process/matrix/node_vectors.h"

namespace tandem::fem {
namespace {

/// Nodes that a thread takes, and whose products are summed, at a time.
constexpr std::size_t kGroup = 256;

std::string text(const char* format, double a, double b, int n) {
  char buffer[200];
  std::snprintf(buffer, sizeof buffer, format, a, b, n);
  return buffer;
}

TANDEM_INLINE double sum_of(const Double4& sums) { return (sums[0] + sums[1]) + sums[2]; }

/// Nodes [begin, end) of z = D⁻¹ r and of r · z; the inverse blocks are symmetric.
TANDEM_INLINE void jacobi_body(const Padded* inverse, const Padded* r, Padded* z, std::size_t begin,
                               std::size_t end, double& product) {
  Double4 sums{};
  for (std::size_t i = begin; i < end; ++i) {
    Double4 z_i{};
    Double4 r_i;
    load(r_i, r[i].at);
    for (int k = 0; k < 3; ++k) {
      Double4 column;
      load(column, inverse[3 * i + static_cast<std::size_t>(k)].at);
      z_i += r_i[k] * column;
    }
    store(z_i, z[i].at);
    sums += r_i * z_i;
  }
  product = sum_of(sums);
}

TANDEM_INLINE void turn_body(double beta, const Padded* z, Padded* p, std::size_t begin,
                             std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    Double4 z_i;
    Double4 p_i;
    load(z_i, z[i].at);
    load(p_i, p[i].at);
    p_i = z_i + beta * p_i;
    store(p_i, p[i].at);
  }
}

TANDEM_INLINE void dot_body(const Padded* a, const Padded* b, std::size_t begin, std::size_t end,
                            double& product) {
  Double4 sums{};
  for (std::size_t i = begin; i < end; ++i) {
    Double4 a_i;
    Double4 b_i;
    load(a_i, a[i].at);
    load(b_i, b[i].at);
    sums += a_i * b_i;
  }
  product = sum_of(sums);
}

TANDEM_INLINE void step_body(double alpha, const Padded* p, const Padded* Ap, Padded* x, Padded* r,
                             std::size_t begin, std::size_t end, double& square) {
  Double4 sums{};
  for (std::size_t i = begin; i < end; ++i) {
    Double4 p_i;
    Double4 Ap_i;
    Double4 x_i;
    Double4 r_i;
    load(p_i, p[i].at);
    load(Ap_i, Ap[i].at);
    load(x_i, x[i].at);
    load(r_i, r[i].at);
    x_i += alpha * p_i;
    r_i -= alpha * Ap_i;
    store(x_i, x[i].at);
    store(r_i, r[i].at);
    sums += r_i * r_i;
  }
  square = sum_of(sums);
}

TANDEM_VECTOR_FUNCTION(jacobi, jacobi_body,
                       (const Padded* inverse, const Padded* r, Padded* z, std::size_t begin,
                        std::size_t end, double& product),
                       (inverse, r, z, begin, end, product))
TANDEM_VECTOR_FUNCTION(turn, turn_body,
                       (double beta, const Padded* z, Padded* p, std::size_t begin,
                        std::size_t end),
                       (beta, z, p, begin, end))
TANDEM_VECTOR_FUNCTION(dot, dot_body,
                       (const Padded* a, const Padded* b, std::size_t begin, std::size_t end,
                        double& product),
                       (a, b, begin, end, product))
TANDEM_VECTOR_FUNCTION(move, step_body,
                       (double alpha, const Padded* p, const Padded* Ap, Padded* x, Padded* r,
                        std::size_t begin, std::size_t end, double& square),
                       (alpha, p, Ap, x, r, begin, end, square))

}  // namespace

PcgSolver::PcgSolver(const SolverParams& params, const BlockPattern& pattern,
                     const RestInverse* rest, ThreadTeam* team)
    : params_(params), pattern_(pattern), rest_(rest), team_(team != nullptr ? *team : alone_) {
  if (rest_ == nullptr) params_.preconditioner = PreconditionerKind::BlockJacobi;
}

SolveReport PcgSolver::factorize(const BlockValues& A, const std::vector<NodeRotation>& rotations) {
  A_ = &A;
  rotations_.clear();
  if (params_.preconditioner == PreconditionerKind::BlockJacobi) return invert_diagonal(A);
  if (params_.preconditioner != PreconditionerKind::RestFactor) rotations_ = rotations;
  return {};
}

SolveReport PcgSolver::invert_diagonal(const BlockValues& A) {
  inverse_diagonal_.resize(3 * static_cast<std::size_t>(pattern_.rows()));
  for (int i = 0; i < pattern_.rows(); ++i) {
    const Eigen::Matrix3d diagonal = block(A, pattern_.find(i, i));
    const Eigen::LLT<Eigen::Matrix3d> llt(diagonal);
    if (llt.info() != Eigen::Success) {
      return {.outcome = Outcome::Failed,
              .message = "the step matrix is not positive definite. Halve fem.micro_step_s."};
    }
    const Eigen::Matrix3d inverse = llt.solve(Eigen::Matrix3d::Identity());
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d column = 0.5 * (inverse.col(k) + inverse.row(k).transpose());
      inverse_diagonal_[static_cast<std::size_t>(3 * i + k)] = {
          {column[0], column[1], column[2], 0.0}};
    }
  }
  return {};
}

SolveReport PcgSolver::solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) {
  if (r.cols() != 1) return solve_columns(params_.tolerance, r, b_norms, nullptr);
  pad(r.col(0), r_);
  const SolveReport report = solve_column(b_norms(0));
  Eigen::VectorXd x;
  unpad(x_, x);
  r.col(0) = x;
  return report;
}

SolveReport PcgSolver::solve_roughly(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms,
                                     Eigen::MatrixXd& left) {
  return solve_columns(std::sqrt(params_.tolerance), r, b_norms, &left);
}

SolveReport PcgSolver::solve_columns(double tolerance, Eigen::MatrixXd& r,
                                     const Eigen::VectorXd& b_norms, Eigen::MatrixXd* left) {
  const bool jacobi_only = params_.preconditioner == PreconditionerKind::BlockJacobi;
  const PcgSystem system{.pattern = pattern_,
                         .A = *A_,
                         .rest = jacobi_only ? nullptr : rest_,
                         .inverse_diagonal = inverse_diagonal_,
                         .rotations = rotations_,
                         .team = team_};
  if (left != nullptr) left->resize(r.rows(), r.cols());
  // Groups of like sizes: nine columns are five and four.
  const Eigen::Index groups = (r.cols() + 7) / 8;
  SolveReport total;
  EightVectors residual;
  EightVectors x;
  for (Eigen::Index g = 0; g < groups; ++g) {
    const Eigen::Index begin = g * r.cols() / groups;
    const Eigen::Index count = (g + 1) * r.cols() / groups - begin;
    residual.setZero(8, r.rows());
    residual.topRows(count) = r.middleCols(begin, count).transpose();
    PcgColumns::Eight limits = PcgColumns::Eight::Zero();
    limits.head(count) = tolerance * b_norms.segment(begin, count).array();
    SolveReport report = columns_.solve(system, limits, static_cast<int>(count),
                                        params_.max_iterations, residual, x);
    if (report.outcome == Outcome::NotConverged && params_.accept_unconverged && x.allFinite()) {
      report.outcome = Outcome::Done;
      report.message.clear();
    }
    r.middleCols(begin, count) = x.topRows(count).transpose();
    if (left != nullptr) left->middleCols(begin, count) = residual.topRows(count).transpose();
    total.iterations += report.iterations;
    if (report.outcome > total.outcome) {
      total.outcome = report.outcome;
      total.message = report.message;
    }
  }
  return total;
}

SolveReport PcgSolver::solve_column(double b_norm) {
  const double limit = params_.tolerance * b_norm;
  x_.assign(r_.size(), Padded{});
  z_.resize(r_.size());
  Ap_.resize(r_.size());
  p_.assign(r_.size(), Padded{});
  double residual = std::sqrt(sum_groups([&](std::size_t begin, std::size_t end, double& sum) {
    dot(r_.data(), r_.data(), begin, end, sum);
  }));
  SolveReport report;
  double rz = 0.0;
  while (residual > limit && report.iterations < params_.max_iterations) {
    const double rz_next = precondition(residual);
    turn_direction(report.iterations == 0 ? 0.0 : rz_next / rz);
    rz = rz_next;
    const double curvature = multiply_direction();
    if (!(curvature > 0.0)) {
      return {.outcome = Outcome::Failed,
              .message = "the step matrix is not positive definite. Halve fem.micro_step_s.",
              .iterations = report.iterations};
    }
    residual = step(rz / curvature);
    ++report.iterations;
  }
  report.residual = residual;
  if (!(residual <= limit) && !(params_.accept_unconverged && std::isfinite(residual))) {
    report.outcome = Outcome::NotConverged;
    report.message = text("PCG: residual %.3g N, limit %.3g N after %d iterations. ", residual,
                          limit, report.iterations) +
                     "Raise fem.solver.max_iterations or use fem.solver.kind: cholmod.";
  }
  return report;
}

template <class Work>
double PcgSolver::sum_groups(const Work& work) {
  sums_.resize((r_.size() + kGroup - 1) / kGroup);
  team_.run_ranges(r_.size(), kGroup, [&](std::size_t begin, std::size_t end) {
    work(begin, end, sums_[begin / kGroup]);
  });
  return std::accumulate(sums_.begin(), sums_.end(), 0.0);
}

double PcgSolver::precondition(double residual) {
  if (params_.preconditioner != PreconditionerKind::BlockJacobi) {
    return rest_->solve(r_, residual, rotations_, z_, scratch_, team_);
  }
  return sum_groups([&](std::size_t begin, std::size_t end, double& sum) {
    jacobi(inverse_diagonal_.data(), r_.data(), z_.data(), begin, end, sum);
  });
}

void PcgSolver::turn_direction(double beta) {
  team_.run_ranges(r_.size(), kGroup, [&](std::size_t begin, std::size_t end) {
    turn(beta, z_.data(), p_.data(), begin, end);
  });
}

double PcgSolver::multiply_direction() {
  return sum_groups([&](std::size_t begin, std::size_t end, double& sum) {
    multiply_rows(pattern_, *A_, p_.data(), Ap_.data(), begin, end);
    dot(p_.data(), Ap_.data(), begin, end, sum);
  });
}

double PcgSolver::step(double alpha) {
  return std::sqrt(sum_groups([&](std::size_t begin, std::size_t end, double& sum) {
    move(alpha, p_.data(), Ap_.data(), x_.data(), r_.data(), begin, end, sum);
  }));
}

}  // namespace tandem::fem
