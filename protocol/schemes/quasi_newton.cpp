#include <algorithm>
#include <utility>

#include "protocol/schemes/accelerator.h"

namespace tandem {

void QuasiNewton::begin_step(const Eigen::VectorXd& weights, bool last_accepted) {
  if (last_accepted && !current_.empty()) {
    if (kind_ == Kind::Imvj) learn_jacobian();
    if (reused_steps_ > 0) past_.push_back(std::move(current_));
    if (past_.size() > static_cast<std::size_t>(reused_steps_)) past_.erase(past_.begin());
  }
  current_.clear();
  evaluations_ = 0;
  weights_ = weights;
  r_.resize(0);
}

void QuasiNewton::observe(const Eigen::VectorXd& x, const Eigen::VectorXd& r) {
  const bool has_past = !past_.empty() || jacobian_.size() > 0;
  const auto unknowns = static_cast<std::int32_t>(x.size());
  if (++evaluations_ >= (has_past ? kPatience : std::max(kPatience, unknowns + 3))) {
    evaluations_ = 0;
    current_.clear();
    past_.clear();
    jacobian_.resize(0, 0);
  } else if (r_.size() > 0)
    current_.push_back({.dr = r - r_, .dx = x + r - (x_ + r_)});
  x_ = x;
  r_ = r;
}

void QuasiNewton::extend(const Column& column, Basis& basis) const {
  const auto rank = static_cast<Eigen::Index>(basis.columns.size());
  Eigen::VectorXd v = weights_.cwiseProduct(column.dr);
  const double size = v.norm();
  if (rank == v.size() || !(size > 0.0)) return;
  const auto Q = basis.Q.leftCols(rank);
  Eigen::VectorXd projection = Eigen::VectorXd::Zero(rank);
  // Twice: one pass of Gram and Schmidt leaves what cancellation has lost.
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::VectorXd more = Q.transpose() * v;
    v -= Q * more;
    projection += more;
  }
  const double rest = v.norm();
  if (!(rest > filter_ * size)) return;
  basis.Q.conservativeResize(v.size(), rank + 1);
  basis.Q.col(rank) = v / rest;
  basis.R.conservativeResize(rank + 1, rank + 1);
  basis.R.row(rank).setZero();
  basis.R.col(rank).head(rank) = projection;
  basis.R(rank, rank) = rest;
  basis.columns.push_back(&column);
}

QuasiNewton::Basis QuasiNewton::orthogonalise() const {
  Basis basis;
  basis.Q.resize(weights_.size(), 0);
  const auto take = [&](const Columns& columns) {
    for (auto c = columns.rbegin(); c != columns.rend(); ++c) extend(*c, basis);
  };
  take(current_);
  for (auto step = past_.rbegin(); step != past_.rend(); ++step) take(*step);
  return basis;
}

Eigen::VectorXd QuasiNewton::next() {
  const Basis basis = orthogonalise();
  const bool no_jacobian = jacobian_.size() == 0;
  if (basis.columns.empty() && no_jacobian) return x_ + first_factor_ * r_;
  Eigen::VectorXd alpha = -(basis.Q.transpose() * weights_.cwiseProduct(r_));
  if (alpha.size() > 0) basis.R.triangularView<Eigen::Upper>().solveInPlace(alpha);
  Eigen::VectorXd x = x_ + r_;
  Eigen::VectorXd secant_r = r_;  // what the columns leave of the residual, r + V α
  for (std::size_t i = 0; i < basis.columns.size(); ++i) {
    x += alpha[static_cast<Eigen::Index>(i)] * basis.columns[i]->dx;
    secant_r += alpha[static_cast<Eigen::Index>(i)] * basis.columns[i]->dr;
  }
  // − J r + (W − J V) α = W α − J (r + V α).
  if (!no_jacobian) x -= jacobian_ * secant_r;
  return x;
}

void QuasiNewton::learn_jacobian() {
  const Basis basis = orthogonalise();
  if (basis.columns.empty()) return;
  const Eigen::Index n = weights_.size();
  const auto rank = static_cast<Eigen::Index>(basis.columns.size());
  if (jacobian_.size() == 0) jacobian_ = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd news(n, rank);
  for (Eigen::Index i = 0; i < rank; ++i) {
    const Column& column = *basis.columns[static_cast<std::size_t>(i)];
    news.col(i) = column.dx - jacobian_ * column.dr;
  }
  // V⁺ = R⁻¹ Qᵀ W.
  Eigen::MatrixXd pseudo_inverse = basis.Q.transpose() * weights_.asDiagonal();
  basis.R.triangularView<Eigen::Upper>().solveInPlace(pseudo_inverse);
  jacobian_ += news * pseudo_inverse;
}

}  // namespace tandem
