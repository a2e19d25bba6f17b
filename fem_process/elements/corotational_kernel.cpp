#include "fem_process/elements/corotational_kernel.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fem_process/elements/corotational_lanes.h"
#include "fem_process/kernels/polar_lanes.h"
#include "fem_process/kernels/simd.h"
#include "fem_process/matrix/lattice.h"
#include "fem_process/matrix/node_vectors.h"

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

  Lanes volume;
  load(volume, batch.volume.data());
  Lanes A[9];
  Lanes sigma[9];
  turn_back(R, F, A);
  corotated_stress(A, volume, lambda, mu, sigma);
  Lanes root;
  load(root, batch.root_volume.data());
  Lanes force[12];
  Lanes turned[12];
  for (int a = 0; a < 3; ++a) {
    Lanes P[3];
    turned_row(R, sigma, a, P);
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

std::vector<Eigen::Vector3d> centres_of(const std::vector<TetShape>& shapes,
                                        const std::vector<Eigen::Vector3d>& positions) {
  std::vector<Eigen::Vector3d> centres;
  centres.reserve(shapes.size());
  for (const TetShape& shape : shapes) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int node : shape.nodes) sum += positions[static_cast<std::size_t>(node)];
    centres.emplace_back(0.25 * sum);
  }
  return centres;
}

/// Where each number stands in a permutation.
std::vector<int> inverse_of(const std::vector<int>& order) {
  std::vector<int> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    place[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  }
  return place;
}

}  // namespace

CorotationalKernel::CorotationalKernel(const std::vector<TetShape>& shapes,
                                       const BlockPattern& pattern, const Material& material,
                                       const std::vector<Eigen::Vector3d>& positions)
    : CorotationalKernel(shapes, pattern, material, near_order(centres_of(shapes, positions)),
                         near_order(positions)) {}

CorotationalKernel::CorotationalKernel(const std::vector<TetShape>& shapes,
                                       const BlockPattern& pattern, const Material& material,
                                       const std::vector<int>& elements,
                                       const std::vector<int>& nodes)
    : lambda_(elasticity(material)(0, 1)),
      mu_(elasticity(material)(3, 3)),
      assembly_(shapes, inverse_of(elements), nodes, pattern, lambda_, mu_) {
  for (std::size_t first = 0; first < shapes.size(); first += kLanes) {
    Batch& batch = batches_.emplace_back();
    batch.count = static_cast<int>(std::min<std::size_t>(kLanes, shapes.size() - first));
    for (std::size_t n = 0; n < kLanes; ++n) {
      const int element = elements[std::min(first + n, shapes.size() - 1)];
      const TetShape& shape = shapes[static_cast<std::size_t>(element)];
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
