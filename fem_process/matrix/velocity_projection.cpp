#include "fem_process/matrix/velocity_projection.h"

#include <array>
#include <cmath>
#include <utility>

#include "fem_process/kernels/simd.h"

namespace tandem::fem {
namespace {

using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Vector8d = Eigen::Matrix<double, 8, 1>;

/// Nodes that a thread takes, and whose products are summed, at a time.
constexpr std::size_t kGroup = 256;

/// Products of a group of nodes: columns of v_jᵀ S v_k, and v_jᵀ b behind them.
using Products = std::array<double, 72>;

template <class Registers>
TANDEM_INLINE void products_body(const double* past, const double* S_past, const double* b,
                                 std::size_t begin, std::size_t end, double* products) {
  using Lanes = typename Registers::Double8;
  Lanes sum[9] = {};
  for (std::size_t i = begin; i < end; ++i) {
    Lanes v;
    load(v, past + 8 * i);
    for (std::size_t k = 0; k < 8; ++k) sum[k] += S_past[8 * i + k] * v;
    sum[8] += b[i] * v;
  }
  for (int k = 0; k < 9; ++k) store(sum[k], products + 8 * k);
}

/// The nodes' vectors Σ y_k v_k.
template <class Registers>
TANDEM_INLINE void sum_body(const double* past, const double* y, std::size_t begin, std::size_t end,
                            double* v) {
  using Lanes = typename Registers::Double8;
  Lanes weight;
  load(weight, y);
  for (std::size_t i = begin; i < end; ++i) {
    Double4 sum[4] = {};
    for (std::size_t a = 0; a < 3; ++a) {
      Lanes term;
      load(term, past + 8 * (3 * i + a));
      term = term * weight;
      Double4 low;
      Double4 high;
      Registers::split(term, low, high);
      sum[a] = low + high;
    }
    transpose(sum[0], sum[1], sum[2], sum[3]);
    const Double4 total = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    for (std::size_t a = 0; a < 3; ++a) v[3 * i + a] = total[a];
  }
}

TANDEM_REGISTER_FUNCTION(multiply_group, products_body,
                         (const double* past, const double* S_past, const double* b,
                          std::size_t begin, std::size_t end, double* products),
                         (past, S_past, b, begin, end, products))
TANDEM_REGISTER_FUNCTION(sum_group, sum_body,
                         (const double* past, const double* y, std::size_t begin, std::size_t end,
                          double* v),
                         (past, y, begin, end, v))

/// Solves G y = h for a positive semidefinite G of unit diagonal by Cholesky's factorisation with
/// pivots; what has no pivot above round-off stays zero.
Vector8d solve_semidefinite(Matrix8d G, Vector8d h) {
  constexpr double kRoundOff = 1e-14;
  std::array<Eigen::Index, 8> order{0, 1, 2, 3, 4, 5, 6, 7};
  Eigen::Index rank = 0;
  for (; rank < 8; ++rank) {
    Eigen::Index pivot = 0;
    if (!(G.diagonal().tail(8 - rank).maxCoeff(&pivot) > kRoundOff)) break;
    pivot += rank;
    G.row(rank).swap(G.row(pivot));
    G.col(rank).swap(G.col(pivot));
    std::swap(h[rank], h[pivot]);
    std::swap(order[static_cast<std::size_t>(rank)], order[static_cast<std::size_t>(pivot)]);
    G(rank, rank) = std::sqrt(G(rank, rank));
    h[rank] /= G(rank, rank);
    for (Eigen::Index i = rank + 1; i < 8; ++i) {
      G(i, rank) /= G(rank, rank);
      h[i] -= G(i, rank) * h[rank];
    }
    for (Eigen::Index i = rank + 1; i < 8; ++i) {
      for (Eigen::Index j = rank + 1; j <= i; ++j) G(j, i) = G(i, j) -= G(i, rank) * G(j, rank);
    }
  }
  Vector8d y = Vector8d::Zero();
  for (Eigen::Index k = rank; k-- > 0;) {
    double sum = h[k];
    for (Eigen::Index i = k + 1; i < rank; ++i) {
      sum -= G(i, k) * y[order[static_cast<std::size_t>(i)]];
    }
    y[order[static_cast<std::size_t>(k)]] = sum / G(k, k);
  }
  return y;
}

}  // namespace

Eigen::VectorXd project(const EightVectors& past, const EightVectors& S_past,
                        const Eigen::VectorXd& b, ThreadTeam& team) {
  const auto nodes = static_cast<std::size_t>(b.size()) / 3;
  std::vector<Products> groups((nodes + kGroup - 1) / kGroup);
  team.run_ranges(nodes, kGroup, [&](std::size_t begin, std::size_t end) {
    multiply_group(past.data(), S_past.data(), b.data(), 3 * begin, 3 * end,
                   groups[begin / kGroup].data());
  });
  Eigen::Matrix<double, 8, 9> sum = Eigen::Matrix<double, 8, 9>::Zero();
  for (const Products& group : groups) {
    sum += Eigen::Map<const Eigen::Matrix<double, 8, 9>>(group.data());
  }
  const Matrix8d G = 0.5 * (sum.leftCols<8>() + sum.leftCols<8>().transpose());
  Vector8d scale;
  for (int k = 0; k < 8; ++k) scale[k] = G(k, k) > 0.0 ? 1.0 / std::sqrt(G(k, k)) : 0.0;
  const Vector8d y =
      scale.asDiagonal() * solve_semidefinite(scale.asDiagonal() * G * scale.asDiagonal(),
                                              scale.asDiagonal() * sum.col(8));
  Eigen::VectorXd v(b.size());
  team.run_ranges(nodes, kGroup, [&](std::size_t begin, std::size_t end) {
    sum_group(past.data(), y.data(), begin, end, v.data());
  });
  return v;
}

}  // namespace tandem::fem
