#include "fem_process/elements/tet10_kernel.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fem_process/elements/corotational_lanes.h"
#include "fem_process/elements/tet10_lanes.h"
#include "fem_process/kernels/simd.h"
#include "fem_process/matrix/node_vectors.h"

namespace tandem::fem {
namespace {

/// Batches that a thread takes at a time.
constexpr std::size_t kGrain = 8;

/// One integration point: adds the forces of nodes 1 … 9, writes their vectors c (all 30 numbers,
/// those of node 0 in front), returns the bits of the inverted lanes.
template <class Lanes>
TANDEM_INLINE int evaluate_point(const Tet10Kernel::Point& point, const Lanes (&edge)[27],
                                 double lambda, double mu, Lanes (&force)[27],
                                 double (&c)[30][kLanes]) {
  LaneMatrix<Lanes> F;
  gradient_at(point, edge, F);
  LaneMatrix<Lanes> R;
  const int inverted = polar_lanes(F, R);
  Lanes volume;
  Lanes root;
  load(volume, point.volume.data());
  load(root, point.root_volume.data());
  Lanes A[9];
  Lanes sigma[9];
  turn_back(R, F, A);
  corotated_stress(A, volume, lambda, mu, sigma);
  for (int a = 0; a < 3; ++a) {
    Lanes P[3];
    turned_row(R, sigma, a, P);
    Lanes turn[3];
    for (int b = 0; b < 3; ++b) turn[b] = root * R.at[3 * a + b];
    Lanes sum{};
    for (int i = 0; i < 9; ++i) {
      Lanes g[3];
      for (int b = 0; b < 3; ++b) {
        load(g[b], point.gradient[static_cast<std::size_t>(3 * i + b)].data());
      }
      force[3 * i + a] += P[0] * g[0] + P[1] * g[1] + P[2] * g[2];
      const Lanes turned = turn[0] * g[0] + turn[1] * g[1] + turn[2] * g[2];
      store(turned, c[3 * i + 3 + a]);
      sum += turned;
    }
    store(-sum, c[a]);
  }
  return inverted;
}

/// One batch: writes its nodes' forces and vectors c, returns the bits of the inverted lanes.
template <class Registers>
TANDEM_INLINE int evaluate_batch(const Tet10Kernel::Batch& batch, double lambda, double mu,
                                 const Padded* x, Padded* f, FourVectors* c) {
  using Lanes = typename Registers::Double8;
  Lanes edge[27];
  gather_edges<Registers>(batch, x, edge);
  Lanes force[27] = {};
  double turned[4][30][kLanes];
  int inverted = 0;
  for (std::size_t p = 0; p < 4; ++p) {
    inverted |= evaluate_point(batch.points[p], edge, lambda, mu, force, turned[p]);
  }
  constexpr int kStride = 40;
  Lanes first[3] = {};
  for (int i = 0; i < 9; ++i) {
    for (int a = 0; a < 3; ++a) first[a] = first[a] - force[3 * i + a];
    scatter_lanes<Registers>(force[3 * i], force[3 * i + 1], force[3 * i + 2], f[i + 1].at,
                             kStride);
  }
  scatter_lanes<Registers>(first[0], first[1], first[2], f[0].at, kStride);
  for (int row = 0; row < 30; ++row) scatter_four<Registers>(turned, row, c);
  return inverted & ((1 << batch.count) - 1);
}

template <class Registers>
TANDEM_INLINE void evaluate_body(const Tet10Kernel::Batch* batch, std::size_t count, double lambda,
                                 double mu, const Padded* x, Padded* f, FourVectors* c,
                                 int& inverted) {
  for (std::size_t b = 0; b < count; ++b) {
    const std::size_t first = 10 * kLanes * b;
    for (int bits = evaluate_batch<Registers>(batch[b], lambda, mu, x, f + first, c + first);
         bits != 0; bits &= bits - 1) {
      ++inverted;
    }
  }
}

TANDEM_REGISTER_FUNCTION(evaluate_tet10_batches, evaluate_body,
                         (const Tet10Kernel::Batch* batch, std::size_t count, double lambda,
                          double mu, const Padded* x, Padded* f, FourVectors* c, int& inverted),
                         (batch, count, lambda, mu, x, f, c, inverted))

}  // namespace

Tet10Kernel::Tet10Kernel(const std::vector<SolidElement<10>>& elements, const BlockPattern& pattern,
                         const Material& material)
    : lambda_(elasticity(material)(0, 1)),
      mu_(elasticity(material)(3, 3)),
      assembly_(elements, pattern, lambda_, mu_) {
  for (std::size_t first = 0; first < elements.size(); first += kLanes) {
    Batch& batch = batches_.emplace_back();
    batch.count = static_cast<int>(std::min<std::size_t>(kLanes, elements.size() - first));
    for (std::size_t n = 0; n < kLanes; ++n) {
      const SolidElement<10>& element = elements[std::min(first + n, elements.size() - 1)];
      batch.node[n] = element.nodes;
      for (std::size_t p = 0; p < 4; ++p) {
        const SolidElement<10>::Point& from = element.points[p];
        Point& point = batch.points[p];
        for (int k = 0; k < 27; ++k) {
          point.gradient[static_cast<std::size_t>(k)][n] = from.gradients(k / 3 + 1, k % 3);
        }
        point.volume[n] = from.volume;
        point.root_volume[n] = std::sqrt(from.volume);
      }
    }
  }
}

int Tet10Kernel::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K,
                          ThreadTeam& team) const {
  // Kept between calls: fresh memory of this size costs more than the arithmetic.
  static thread_local std::vector<Padded> nodes;
  static thread_local std::vector<FourVectors> c;
  static thread_local std::vector<Padded> f;
  static thread_local std::vector<int> inverted;
  pad(x, nodes);
  c.resize(10 * kLanes * batches_.size());
  f.resize(c.size());
  inverted.assign((batches_.size() + kGrain - 1) / kGrain, 0);
  // The helpers have thread-local vectors of their own.
  FourVectors* const all_c = c.data();
  Padded* const all_f = f.data();
  const Padded* const all_x = nodes.data();
  int* const counts = inverted.data();
  team.run_ranges(batches_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const std::size_t first = 10 * kLanes * begin;
    evaluate_tet10_batches(batches_.data() + begin, end - begin, lambda_, mu_, all_x, all_f + first,
                           all_c + first, counts[begin / kGrain]);
  });
  assembly_.gather(c, f, f_int, K, team);
  return std::accumulate(inverted.begin(), inverted.end(), 0);
}

}  // namespace tandem::fem
