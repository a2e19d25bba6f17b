#include "fem_process/solvers/nearby_solver.h"

#include <utility>

#include "fem_process/solvers/cholmod_solver.h"

namespace tandem::fem {
namespace {

/// Part of a right-hand side that is left: right-hand sides correct a guess, so that this is the
/// round-off of the whole.
constexpr double kLeft = 1e-13;

/// An iteration costs about a twentieth of a factorisation.
constexpr int kMostIterations = 20;

Eigen::Matrix3d matrix_of(const NodeRotation& rotation) {
  Eigen::Matrix3d R;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) R(i, k) = static_cast<double>(rotation.row[i][k]);
  }
  return R;
}

}  // namespace

SolveReport NearbySolver::factorize(const BlockValues& A,
                                    const std::vector<NodeRotation>& rotations) {
  A_ = &A;
  factorised_ = false;
  W_.resize(rotations.size());
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    W_[i] = matrix_of(rotations[i]) * matrix_of(begin_[i]).transpose();
  }
  return {};
}

SolveReport NearbySolver::precondition(const Eigen::VectorXd& r, Eigen::MatrixXd& z) {
  z = r;
  for (std::size_t i = 0; i < W_.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    z.col(0).segment<3>(at) = W_[i].transpose() * r.segment<3>(at);
  }
  const SolveReport report = neighbour_.solve(z, Eigen::VectorXd::Constant(1, r.norm()));
  for (std::size_t i = 0; i < W_.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    z.col(0).segment<3>(at) = (W_[i] * z.col(0).segment<3>(at)).eval();
  }
  return report;
}

bool NearbySolver::iterate(Eigen::VectorXd r, Eigen::VectorXd& x, SolveReport& report) {
  const double limit = kLeft * r.norm();
  Eigen::VectorXd p = Eigen::VectorXd::Zero(r.size());
  Eigen::MatrixXd z;
  double rz = 1.0;
  x.setZero(r.size());
  for (int k = 0; r.norm() > limit; ++k) {
    if (k == kMostIterations || precondition(r, z).outcome != Outcome::Done) return false;
    const double rz_last = std::exchange(rz, r.dot(z.col(0)));
    p = z.col(0) + rz / rz_last * p;
    const Eigen::VectorXd Ap = multiply(pattern_, *A_, p, {}, team_);
    const double curvature = p.dot(Ap);
    if (!(curvature > 0.0)) return false;
    x += rz / curvature * p;
    r -= rz / curvature * Ap;
    ++report.iterations;
  }
  return true;
}

SolveReport NearbySolver::solve(Eigen::MatrixXd& r, const Eigen::VectorXd& b_norms) {
  if (factorised_) return own_->solve(r, b_norms);
  SolveReport report;
  Eigen::MatrixXd X(r.rows(), r.cols());
  Eigen::VectorXd x;
  bool solved = true;
  for (Eigen::Index c = 0; solved && c < r.cols(); ++c) {
    solved = iterate(r.col(c), x, report);
    X.col(c) = x;
  }
  if (solved) {
    r = X;
    return report;
  }
  if (!own_) own_ = std::make_unique<CholmodSolver>(pattern_);
  const SolveReport made = own_->factorize(*A_);
  if (made.outcome != Outcome::Done) return made;
  factorised_ = true;
  return own_->solve(r, b_norms);
}

}  // namespace tandem::fem
