#include "fem_process/reduced/highest_frequency.h"

#include <Eigen/Eigenvalues>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace tandem::fem {
namespace {

/// Enough for the end of a spectrum: the error falls by the gap to the next eigenvalue.
constexpr Eigen::Index kLanczosSteps = 80;

/// A start that no mode is orthogonal to, for all practical purposes.
Eigen::VectorXd start_vector(Eigen::Index size) {
  Eigen::VectorXd v(size);
  std::uint32_t seed = 1;
  for (Eigen::Index i = 0; i < size; ++i) {
    seed = seed * 1664525U + 1013904223U;
    v(i) = static_cast<double>(seed) / 4294967296.0 - 0.5;
  }
  return v / v.norm();
}

/// Largest eigenvalue of the Lanczos matrix and the bound of its error, the last off-diagonal times
/// the last entry of its vector.
double upper_end(const std::vector<double>& diagonal, const std::vector<double>& beside) {
  const auto n = static_cast<Eigen::Index>(diagonal.size());
  const Eigen::VectorXd d = Eigen::Map<const Eigen::VectorXd>(diagonal.data(), n);
  const Eigen::VectorXd e = Eigen::Map<const Eigen::VectorXd>(beside.data(), n - 1);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
  ritz.computeFromTridiagonal(d, e);
  return ritz.eigenvalues()(n - 1) + beside.back() * std::abs(ritz.eigenvectors()(n - 1, n - 1));
}

/// K of the free nodes at rest.
BlockValues rest_stiffness(const Model& model) {
  Eigen::VectorXd f_int;
  BlockValues whole;
  model.formulation->evaluate(model.reference(), f_int, whole);
  BlockValues K(9 * model.interior.source.size());
  for (std::size_t b = 0; b < model.interior.source.size(); ++b) {
    block(K, static_cast<int>(b)) = block(std::as_const(whole), model.interior.source[b]);
  }
  return K;
}

/// Largest ω of K φ = ω² M φ by Lanczos' iteration in the inner product of M.
/// `solve`: M⁻¹ times, `weigh`: M times.
template <class Solve, class Weigh>
double highest_frequency(const Model& model, const Solve& solve, const Weigh& weigh) {
  const auto size = 3 * static_cast<Eigen::Index>(model.free.size());
  if (size == 0) return 0.0;
  const BlockValues K = rest_stiffness(model);
  const auto norm = [&](const Eigen::VectorXd& v) { return std::sqrt(v.dot(weigh(v))); };
  Eigen::VectorXd q = start_vector(size);
  q /= norm(q);
  Eigen::VectorXd last = Eigen::VectorXd::Zero(size);
  std::vector<double> diagonal;
  std::vector<double> beside;
  for (Eigen::Index k = 0; k < std::min(size, kLanczosSteps); ++k) {
    const Eigen::VectorXd Kq = multiply(model.interior.pattern, K, q);
    diagonal.push_back(q.dot(Kq));
    Eigen::VectorXd w = solve(Kq);
    w -= diagonal.back() * q + (beside.empty() ? 0.0 : beside.back()) * last;
    beside.push_back(norm(w));
    if (beside.back() <= 1e-12 * std::abs(diagonal.front())) break;  // all modes found
    last = q;
    q = w / beside.back();
  }
  return std::sqrt(std::max(0.0, upper_end(diagonal, beside)));
}

using ScalarMatrix = Eigen::SparseMatrix<double>;

/// Masses of the free nodes, one number a pair of nodes.
ScalarMatrix free_mass(const Model& model) {
  const BlockPattern& pattern = model.interior.pattern;
  std::vector<Eigen::Triplet<double>> entries;
  for (int row = 0; row < pattern.rows(); ++row) {
    for (int b = pattern.row_start[static_cast<std::size_t>(row)];
         b < pattern.row_start[static_cast<std::size_t>(row) + 1]; ++b) {
      const auto at = static_cast<std::size_t>(b);
      entries.emplace_back(row, pattern.column[at],
                           model.mass[static_cast<std::size_t>(model.interior.source[at])]);
    }
  }
  ScalarMatrix M(pattern.rows(), pattern.rows());
  M.setFromTriplets(entries.begin(), entries.end());
  return M;
}

}  // namespace

double highest_angular_frequency(const Model& model) {
  Eigen::VectorXd mass(3 * static_cast<Eigen::Index>(model.free.size()));
  for (std::size_t i = 0; i < model.free.size(); ++i) {
    mass.segment<3>(3 * static_cast<Eigen::Index>(i))
        .setConstant(model.nodal_mass[static_cast<std::size_t>(model.free[i])]);
  }
  return highest_frequency(
      model, [&](const Eigen::VectorXd& f) { return Eigen::VectorXd(f.cwiseQuotient(mass)); },
      [&](const Eigen::VectorXd& v) { return Eigen::VectorXd(mass.cwiseProduct(v)); });
}

double highest_step_frequency(const Model& model) {
  if (model.free.empty()) return 0.0;
  const ScalarMatrix M = free_mass(model);
  // Far better conditioned than K: some twenty iterations, on any mesh.
  Eigen::ConjugateGradient<ScalarMatrix, Eigen::Lower | Eigen::Upper> inverse(M);
  inverse.setTolerance(1e-13);
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  const auto by_node = [](const Eigen::VectorXd& v) {
    return Eigen::Map<const Rows>(v.data(), v.size() / 3, 3);
  };
  const auto flat = [](const Rows& rows) {
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(rows.data(), rows.size()));
  };
  return highest_frequency(
      model,
      [&](const Eigen::VectorXd& f) {
        Rows solved(f.size() / 3, 3);
        for (int i = 0; i < 3; ++i) {
          solved.col(i) = inverse.solve(Eigen::VectorXd(by_node(f).col(i)));
        }
        return flat(solved);
      },
      [&](const Eigen::VectorXd& v) { return flat(Rows(M * by_node(v))); });
}

double newmark_step_limit_s(double beta, double gamma, double w) {
  const double lacking = 0.5 * gamma - beta;
  if (lacking <= 0.0 || w <= 0.0) return std::numeric_limits<double>::infinity();
  return 1.0 / (w * std::sqrt(lacking));
}

double explicit_step_limit_s(const Model& model) {
  const double w = highest_angular_frequency(model);
  const Damping& damping = model.params.damping;
  if (w <= 0.0) {
    return damping.alpha_per_s > 0.0 ? 2.0 / damping.alpha_per_s
                                     : std::numeric_limits<double>::infinity();
  }
  const double zeta = 0.5 * (damping.alpha_per_s / w + damping.beta_s * w);
  return 2.0 * (std::sqrt(1.0 + zeta * zeta) - zeta) / w;
}

}  // namespace tandem::fem
