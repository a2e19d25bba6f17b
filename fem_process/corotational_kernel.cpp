#include "fem_process/corotational_kernel.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fem_process/node_vectors.h"
#include "fem_process/polar_lanes.h"
#include "fem_process/simd.h"

namespace tandem::fem {
namespace {

/// Batches that a thread takes at a time.
constexpr std::size_t kGrain = 32;

/// One batch: writes its corners' forces and vectors c, returns the bits of the inverted lanes.
template <class Registers>
TANDEM_INLINE int evaluate_batch(const CorotationalKernel::Batch& batch, double lambda, double mu,
                                 const Padded* x, Padded* f, Padded* c) {
  using Lanes = typename Registers::Double8;
  Double4 ends[3][kLanes];  // from corner 0 to the others
  for (std::size_t n = 0; n < kLanes; ++n) {
    Double4 origin;
    load(origin, x[batch.node[n][0]].at);
    for (std::size_t k = 0; k < 3; ++k) {
      load(ends[k][n], x[batch.node[n][k + 1]].at);
      ends[k][n] -= origin;
    }
  }
  Lanes edge[9];
  for (int k = 0; k < 3; ++k) {
    gather_lanes<Registers>(ends[k], edge[3 * k], edge[3 * k + 1], edge[3 * k + 2]);
  }
  Lanes g[9];
  for (std::size_t k = 0; k < 9; ++k) load(g[k], batch.gradient[k].data());
  LaneMatrix<Lanes> F;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      F.at[3 * a + b] = edge[a] * g[b] + edge[3 + a] * g[3 + b] + edge[6 + a] * g[6 + b];
    }
  }
  LaneMatrix<Lanes> R;
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
  const Lanes pressure = lambda * volume * (e0 + e1 + e2);
  const Lanes twice = (2.0 * mu) * volume;
  const Lanes shear = mu * volume;
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
  for (int i = 0; i < 4; ++i) {
    constexpr int kStride = 16;
    scatter_lanes<Registers>(force[3 * i], force[3 * i + 1], force[3 * i + 2], f[i].at, kStride);
    scatter_lanes<Registers>(turned[3 * i], turned[3 * i + 1], turned[3 * i + 2], c[i].at, kStride);
  }
  return inverted & ((1 << batch.count) - 1);
}

template <class Registers>
TANDEM_INLINE void evaluate_body(const CorotationalKernel::Batch* batch, std::size_t count,
                                 double lambda, double mu, const Padded* x, Padded* f, Padded* c,
                                 int& inverted) {
  for (std::size_t b = 0; b < count; ++b) {
    const std::size_t first = 4 * kLanes * b;
    for (int bits = evaluate_batch<Registers>(batch[b], lambda, mu, x, f + first, c + first);
         bits != 0; bits &= bits - 1) {
      ++inverted;
    }
  }
}

TANDEM_REGISTER_FUNCTION(evaluate_batches, evaluate_body,
                         (const CorotationalKernel::Batch* batch, std::size_t count, double lambda,
                          double mu, const Padded* x, Padded* f, Padded* c, int& inverted),
                         (batch, count, lambda, mu, x, f, c, inverted))

}  // namespace

CorotationalKernel::CorotationalKernel(const std::vector<TetShape>& shapes,
                                       const BlockPattern& pattern, const Material& material)
    : lambda_(elasticity(material)(0, 1)),
      mu_(elasticity(material)(3, 3)),
      assembly_(shapes, pattern, lambda_, mu_) {
  for (std::size_t first = 0; first < shapes.size(); first += kLanes) {
    Batch& batch = batches_.emplace_back();
    batch.count = static_cast<int>(std::min<std::size_t>(kLanes, shapes.size() - first));
    for (std::size_t n = 0; n < kLanes; ++n) {
      const TetShape& shape = shapes[std::min(first + n, shapes.size() - 1)];
      batch.node[n] = shape.nodes;
      for (int k = 0; k < 9; ++k) {
        batch.gradient[static_cast<std::size_t>(k)][n] = shape.gradients(k / 3 + 1, k % 3);
      }
      batch.volume[n] = shape.volume;
      batch.root_volume[n] = std::sqrt(shape.volume);
    }
  }
}

int CorotationalKernel::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K,
                                 ThreadTeam& team) const {
  // Kept between calls: fresh memory of this size costs more than the arithmetic.
  static thread_local std::vector<Padded> nodes;
  static thread_local std::vector<Padded> c;
  static thread_local std::vector<Padded> f;
  static thread_local std::vector<int> inverted;
  pad(x, nodes);
  c.resize(4 * kLanes * batches_.size());
  f.resize(c.size());
  inverted.assign((batches_.size() + kGrain - 1) / kGrain, 0);
  // The helpers have thread-local vectors of their own.
  Padded* const all_c = c.data();
  Padded* const all_f = f.data();
  const Padded* const all_x = nodes.data();
  int* const counts = inverted.data();
  team.run_ranges(batches_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    evaluate_batches(batches_.data() + begin, end - begin, lambda_, mu_, all_x,
                     all_f + 4 * kLanes * begin, all_c + 4 * kLanes * begin,
                     counts[begin / kGrain]);
  });
  assembly_.gather(c, f, f_int, K, team);
  return std::accumulate(inverted.begin(), inverted.end(), 0);
}

}  // namespace tandem::fem
