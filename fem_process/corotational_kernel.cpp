#include "fem_process/corotational_kernel.h"

#include <algorithm>
#include <cmath>

#include "fem_process/polar_lanes.h"
#include "fem_process/simd.h"

namespace tandem::fem {
namespace {

/// Per corner three numbers and one idle lane.
constexpr int kCornerStride = 4;
constexpr int kElementStride = 4 * kCornerStride;

/// One batch: adds its forces, writes its vectors c, returns the bits of the inverted lanes.
TANDEM_INLINE int evaluate_batch(const CorotationalKernel::Batch& batch, double lambda, double mu,
                                 const double* x, double* f, double* c) {
  double ends[9][kLanes];  // edge to corner k + 1, coordinate a, at 3 k + a
  for (std::size_t n = 0; n < kLanes; ++n) {
    const double* origin = x + 3 * static_cast<std::ptrdiff_t>(batch.node[0][n]);
    for (std::size_t k = 0; k < 3; ++k) {
      const double* end = x + 3 * static_cast<std::ptrdiff_t>(batch.node[k + 1][n]);
      for (std::size_t a = 0; a < 3; ++a) ends[3 * k + a][n] = end[a] - origin[a];
    }
  }
  Lanes edge[9];
  for (int k = 0; k < 9; ++k) load(edge[k], ends[k]);
  Lanes g[9];
  for (std::size_t k = 0; k < 9; ++k) load(g[k], batch.gradient[k].data());
  LaneMatrix F;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      F.at[3 * a + b] = edge[a] * g[b] + edge[3 + a] * g[3 + b] + edge[6 + a] * g[6 + b];
    }
  }
  LaneMatrix R;
  const int inverted = polar_lanes(F, R);

  // V σ, σ symmetric: of the strain in the turned axes.
  Lanes A[9];  // Rᵀ F
  for (int k = 0; k < 9; ++k) {
    const int i = k / 3;
    const int j = k % 3;
    A[k] = R.at[i] * F.at[j] + R.at[3 + i] * F.at[3 + j] + R.at[6 + i] * F.at[6 + j];
  }
  const Lanes e0 = A[0] - 1.0;
  const Lanes e1 = A[4] - 1.0;
  const Lanes e2 = A[8] - 1.0;
  Lanes volume;
  load(volume, batch.volume.data());
  const Lanes pressure = volume * lambda * (e0 + e1 + e2);
  const Lanes twice = volume * (2.0 * mu);
  const Lanes shear = volume * mu;
  const Lanes s01 = shear * (A[1] + A[3]);
  const Lanes s12 = shear * (A[5] + A[7]);
  const Lanes s02 = shear * (A[2] + A[6]);
  const Lanes sigma[9] = {pressure + twice * e0, s01, s02, s01,
                          pressure + twice * e1, s12, s02, s12,
                          pressure + twice * e2};
  Lanes root;
  load(root, batch.root_volume.data());
  Lanes force[12];
  Lanes turned[12];
  for (int a = 0; a < 3; ++a) {
    Lanes P[3];
    for (int b = 0; b < 3; ++b) {
      P[b] =
          R.at[3 * a] * sigma[b] + R.at[3 * a + 1] * sigma[3 + b] + R.at[3 * a + 2] * sigma[6 + b];
    }
    for (int i = 0; i < 3; ++i) {
      const Lanes* g_i = g + 3 * i;
      force[3 * i + 3 + a] = P[0] * g_i[0] + P[1] * g_i[1] + P[2] * g_i[2];
      turned[3 * i + 3 + a] =
          root * (R.at[3 * a] * g_i[0] + R.at[3 * a + 1] * g_i[1] + R.at[3 * a + 2] * g_i[2]);
    }
    force[a] = -(force[3 + a] + force[6 + a] + force[9 + a]);
    turned[a] = -(turned[3 + a] + turned[6 + a] + turned[9 + a]);
  }
  for (int n = 0; n < batch.count; ++n) {
    for (int i = 0; i < 4; ++i) {
      double* f_i =
          f + 3 * static_cast<std::ptrdiff_t>(
                      batch.node[static_cast<std::size_t>(i)][static_cast<std::size_t>(n)]);
      double* c_i = c + n * kElementStride + i * kCornerStride;
      for (int a = 0; a < 3; ++a) {
        f_i[a] += force[3 * i + a][n];
        c_i[a] = turned[3 * i + a][n];
      }
    }
  }
  return inverted & ((1 << batch.count) - 1);
}

TANDEM_INLINE void evaluate_body(const std::vector<CorotationalKernel::Batch>& batches,
                                 double lambda, double mu, const double* x, double* f, double* c,
                                 int& inverted) {
  for (const CorotationalKernel::Batch& batch : batches) {
    for (int bits = evaluate_batch(batch, lambda, mu, x, f, c); bits != 0; bits &= bits - 1) {
      ++inverted;
    }
    c += kLanes * kElementStride;
  }
}

TANDEM_VECTOR_FUNCTION(evaluate_batches, evaluate_body,
                       (const std::vector<CorotationalKernel::Batch>& batches, double lambda,
                        double mu, const double* x, double* f, double* c, int& inverted),
                       (batches, lambda, mu, x, f, c, inverted))

/// λ D + μ Dᵀ + μ tr D I.
Block stiffness(const Block& D, double lambda, double mu) {
  Block K = lambda * D + mu * D.transpose();
  K.diagonal().array() += mu * D.trace();
  return K;
}

}  // namespace

CorotationalKernel::CorotationalKernel(const std::vector<TetShape>& shapes,
                                       const BlockPattern& pattern, const Material& material) {
  const Matrix6d elastic = elasticity(material);
  lambda_ = elastic(0, 1);
  mu_ = elastic(3, 3);
  for (std::size_t first = 0; first < shapes.size(); first += kLanes) {
    Batch& batch = batches_.emplace_back();
    batch.count = static_cast<int>(std::min<std::size_t>(kLanes, shapes.size() - first));
    for (std::size_t n = 0; n < kLanes; ++n) {
      const TetShape& shape = shapes[std::min(first + n, shapes.size() - 1)];
      for (std::size_t i = 0; i < 4; ++i) batch.node[i][n] = shape.nodes[i];
      for (int k = 0; k < 9; ++k) {
        batch.gradient[static_cast<std::size_t>(k)][n] = shape.gradients(k / 3 + 1, k % 3);
      }
      batch.volume[n] = shape.volume;
      batch.root_volume[n] = std::sqrt(shape.volume);
    }
  }
  list_edges(shapes, pattern);
}

void CorotationalKernel::list_edges(const std::vector<TetShape>& shapes,
                                    const BlockPattern& pattern) {
  std::vector<std::vector<Term>> terms(pattern.blocks());
  for (std::size_t e = 0; e < shapes.size(); ++e) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const auto b =
            static_cast<std::size_t>(shapes[e].blocks[static_cast<std::size_t>(4 * i + j)]);
        const int c = static_cast<int>(e) * kElementStride;
        terms[b].push_back({c + i * kCornerStride, c + j * kCornerStride});
      }
    }
  }
  for (int i = 0; i < pattern.rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    diagonal_.push_back(pattern.find(i, i));
    for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
      const auto at = static_cast<std::size_t>(b);
      const int j = pattern.column[at];
      if (j <= i) continue;
      edges_.push_back({b, pattern.find(j, i), i, j, static_cast<int>(terms_.size())});
      terms_.insert(terms_.end(), terms[at].begin(), terms[at].end());
    }
  }
  edges_.push_back({.first_term = static_cast<int>(terms_.size())});
}

int CorotationalKernel::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int,
                                 BlockValues& K) const {
  // Kept between calls: fresh memory of this size costs more than the arithmetic.
  static thread_local std::vector<double> c;
  c.resize(batches_.size() * kLanes * kElementStride);
  f_int.setZero(x.size());
  int inverted = 0;
  evaluate_batches(batches_, lambda_, mu_, x.data(), f_int.data(), c.data(), inverted);
  assemble(c, K);
  return inverted;
}

void CorotationalKernel::assemble(const std::vector<double>& c, BlockValues& K) const {
  K.resize(9 * static_cast<std::size_t>(2 * (edges_.size() - 1) + diagonal_.size()));
  for (int b : diagonal_) block(K, b).setZero();
  for (std::size_t e = 0; e + 1 < edges_.size(); ++e) {
    const Edge& edge = edges_[e];
    Block D = Block::Zero();
    for (int t = edge.first_term; t < edges_[e + 1].first_term; ++t) {
      const Term& term = terms_[static_cast<std::size_t>(t)];
      const Eigen::Map<const Eigen::Vector3d> c_i(c.data() + term.c_i);
      const Eigen::Map<const Eigen::Vector3d> c_j(c.data() + term.c_j);
      D.noalias() += c_i * c_j.transpose();
    }
    // Gathered as D first; D_ji = D_ijᵀ.
    block(K, diagonal_[static_cast<std::size_t>(edge.i)]) -= D;
    block(K, diagonal_[static_cast<std::size_t>(edge.j)]) -= D.transpose();
    const Block K_ij = stiffness(D, lambda_, mu_);
    block(K, edge.upper) = K_ij;
    block(K, edge.lower) = K_ij.transpose();
  }
  for (int b : diagonal_) {
    const Block D = block(K, b);
    // Symmetric but for round-off: made so exactly, the solvers take one triangle.
    block(K, b) = stiffness(0.5 * (D + D.transpose()), lambda_, mu_);
  }
}

}  // namespace tandem::fem
