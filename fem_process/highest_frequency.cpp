#include "fem_process/highest_frequency.h"

#include <Eigen/Eigenvalues>
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

}  // namespace

double highest_angular_frequency(const Model& model) {
  const auto size = 3 * static_cast<Eigen::Index>(model.free.size());
  if (size == 0) return 0.0;
  Eigen::VectorXd f_int;
  BlockValues whole;
  model.formulation->evaluate(model.reference(), f_int, whole);
  BlockValues K(9 * model.interior.source.size());
  for (std::size_t b = 0; b < model.interior.source.size(); ++b) {
    block(K, static_cast<int>(b)) = block(std::as_const(whole), model.interior.source[b]);
  }
  Eigen::VectorXd scale(size);
  for (std::size_t i = 0; i < model.free.size(); ++i) {
    const double m = model.nodal_mass[static_cast<std::size_t>(model.free[i])];
    scale.segment<3>(3 * static_cast<Eigen::Index>(i)).setConstant(1.0 / std::sqrt(m));
  }

  Eigen::VectorXd q = start_vector(size);
  Eigen::VectorXd last = Eigen::VectorXd::Zero(size);
  std::vector<double> diagonal;
  std::vector<double> beside;
  for (Eigen::Index k = 0; k < std::min(size, kLanczosSteps); ++k) {
    Eigen::VectorXd w = scale.cwiseProduct(
        multiply(model.interior.pattern, K, Eigen::VectorXd(scale.cwiseProduct(q))));
    diagonal.push_back(q.dot(w));
    w -= diagonal.back() * q + (beside.empty() ? 0.0 : beside.back()) * last;
    beside.push_back(w.norm());
    if (beside.back() <= 1e-12 * std::abs(diagonal.front())) break;  // all modes found
    last = q;
    q = w / beside.back();
  }
  return std::sqrt(std::max(0.0, upper_end(diagonal, beside)));
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
