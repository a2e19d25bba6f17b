#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fem_process/polar.h"
#include "fem_process/simd.h"

namespace tandem::fem {

/// Four numbers side by side: one per element or node.
constexpr int kLanes = 4;
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));

/// A 3 × 3 matrix per lane, row by row.
struct LaneMatrix {
  Lanes at[9];
};

TANDEM_INLINE void load(Lanes& lanes, const double* from) {
  std::memcpy(&lanes, from, sizeof lanes);
}

/// R⁻ᵀ det R.
TANDEM_INLINE void cofactor(const LaneMatrix& R, LaneMatrix& c) {
  const Lanes* a = R.at;
  for (int i = 0; i < 3; ++i) {
    const int p = 3 * ((i + 1) % 3);
    const int q = 3 * ((i + 2) % 3);
    for (int j = 0; j < 3; ++j) {
      const int k = (j + 1) % 3;
      const int l = (j + 2) % 3;
      c.at[3 * i + j] = a[p + k] * a[q + l] - a[p + l] * a[q + k];
    }
  }
}

/// R = polar(F) per lane, by Newton's iteration R ← ½ (R + R⁻ᵀ) [Higham 1986]. Lanes with det F
/// near or below zero, or that do not converge, take polar_rotation(). Returns bit n for an
/// inverted lane n. Lanes are independent but for the number of iterations, which is that of the
/// slowest.
TANDEM_INLINE int polar_lanes(const LaneMatrix& F, LaneMatrix& R) {
  LaneMatrix c;
  cofactor(F, c);
  const Lanes det = F.at[0] * c.at[0] + F.at[1] * c.at[1] + F.at[2] * c.at[2];
  Lanes square{};
  for (const Lanes& entry : F.at) square += entry * entry;
  R = F;
  bool hard[kLanes];
  for (int n = 0; n < kLanes; ++n) {
    hard[n] = !(det[n] > kSingularFraction * square[n] * std::sqrt(square[n]));
    for (int k = 0; hard[n] && k < 9; ++k) R.at[k][n] = k % 4 == 0 ? 1.0 : 0.0;
  }
  // Quadratic convergence: a step below 3e-9 ends within 1e-17 of the limit.
  constexpr double kConverged = 1e-17;
  Lanes change{};
  for (int step = 0; step < 12; ++step) {
    cofactor(R, c);
    const Lanes factor = 0.5 / (R.at[0] * c.at[0] + R.at[1] * c.at[1] + R.at[2] * c.at[2]);
    change = Lanes{};
    for (int k = 0; k < 9; ++k) {
      const Lanes next = 0.5 * R.at[k] + factor * c.at[k];
      change += (next - R.at[k]) * (next - R.at[k]);
      R.at[k] = next;
    }
    if (std::max({change[0], change[1], change[2], change[3]}) < kConverged) break;
  }
  int inverted = 0;
  for (int n = 0; n < kLanes; ++n) {
    if (!hard[n] && change[n] < kConverged) continue;
    Eigen::Matrix3d lane;
    for (int k = 0; k < 9; ++k) lane(k / 3, k % 3) = F.at[k][n];
    const PolarRotation polar = polar_rotation(lane);
    for (int k = 0; k < 9; ++k) R.at[k][n] = polar.R(k / 3, k % 3);
    inverted |= (polar.inverted ? 1 : 0) << n;
  }
  return inverted;
}

}  // namespace tandem::fem
