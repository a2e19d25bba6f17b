#pragma once

#include <cstddef>

#include "fem_process/elements/tet10_kernel.h"
#include "fem_process/kernels/polar_lanes.h"
#include "fem_process/kernels/simd.h"

/// Pieces of the kernels of second-order tetrahedra, eight elements at a time.
namespace tandem::fem {

/// From node 0 to the others, nine vectors.
template <class Registers>
TANDEM_INLINE void gather_edges(const Tet10Kernel::Batch& batch, const Padded* x,
                                typename Registers::Double8 (&edge)[27]) {
  Double4 origin[kLanes];
  for (std::size_t n = 0; n < kLanes; ++n) load(origin[n], x[batch.node[n][0]].at);
  for (std::size_t k = 0; k < 9; ++k) {
    Double4 ends[kLanes];
    for (std::size_t n = 0; n < kLanes; ++n) {
      load(ends[n], x[batch.node[n][k + 1]].at);
      ends[n] -= origin[n];
    }
    gather_lanes<Registers>(ends, edge[3 * k], edge[3 * k + 1], edge[3 * k + 2]);
  }
}

/// Σ x_i ∂N_i/∂X at an integration point, out of those vectors.
template <class Lanes>
TANDEM_INLINE void gradient_at(const Tet10Kernel::Point& point, const Lanes (&edge)[27],
                               LaneMatrix<Lanes>& F) {
  for (std::size_t a = 0; a < 3; ++a) {
    Lanes sum[3] = {};
    for (std::size_t k = 0; k < 9; ++k) {
      for (std::size_t b = 0; b < 3; ++b) {
        Lanes g;
        load(g, point.gradient[3 * k + b].data());
        sum[b] += edge[3 * k + a] * g;
      }
    }
    for (std::size_t b = 0; b < 3; ++b) F.at[3 * a + b] = sum[b];
  }
}

/// Component row % 3 at node row / 3 of four vectors of eight elements → side by side.
template <class Registers>
TANDEM_INLINE void scatter_four(const double (&from)[4][30][kLanes], int row, FourVectors* to) {
  Double4 vector[4][2];
  for (int k = 0; k < 4; ++k) {
    typename Registers::Double8 lanes;
    load(lanes, from[k][row]);
    Registers::split(lanes, vector[k][0], vector[k][1]);
  }
  for (int half = 0; half < 2; ++half) {
    transpose(vector[0][half], vector[1][half], vector[2][half], vector[3][half]);
    for (int n = 0; n < 4; ++n) {
      store(vector[n][half], to[10 * (4 * half + n) + row / 3].at[row % 3]);
    }
  }
}

}  // namespace tandem::fem
