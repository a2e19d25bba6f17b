#pragma once

#include <cstring>

#include "fem_process/kernels/polar.h"
#include "fem_process/kernels/simd.h"

namespace tandem::fem {

/// So many numbers side by side: one per element or node.
constexpr int kLanes = 8;

/// A 3 × 3 matrix per lane, row by row.
template <class Lanes>
struct LaneMatrix {
  Lanes at[9];
};

/// R⁻ᵀ det R.
template <class Lanes>
TANDEM_INLINE void cofactor(const LaneMatrix<Lanes>& R, LaneMatrix<Lanes>& c) {
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

/// Whether all lanes are above zero. (NaN is not.)
template <class Lanes>
TANDEM_INLINE bool all_positive(const Lanes& lanes) {
  double numbers[kLanes];
  store(lanes, numbers);
  int positive = 0;
  for (const double number : numbers) positive += number > 0.0 ? 1 : 0;
  return positive == kLanes;
}

/// What Newton's iteration is not to be trusted with: lanes with det F near or below zero, or that
/// have not converged. `det` and `margin` are positive in the others.
template <class Lanes>
struct Trust {
  Lanes det;     ///< det F
  Lanes margin;  ///< det² F − ε² ‖F‖⁶
};

/// Starts untrusted lanes from I, so that they converge with the others.
template <class Lanes>
void replace_untrusted(const Trust<Lanes>& trust, LaneMatrix<Lanes>& R) {
  double trusted[2][kLanes];
  double entries[9][kLanes];
  std::memcpy(trusted, &trust, sizeof trusted);
  std::memcpy(entries, &R, sizeof entries);
  for (int n = 0; n < kLanes; ++n) {
    if (trusted[0][n] > 0.0 && trusted[1][n] > 0.0) continue;
    for (int k = 0; k < 9; ++k) entries[k][n] = k % 4 == 0 ? 1.0 : 0.0;
  }
  std::memcpy(&R, entries, sizeof entries);
}

/// Gives untrusted lanes, and those that have not converged, polar_rotation(F). Returns bit n for
/// an inverted lane n.
template <class Lanes>
int repair_untrusted(const LaneMatrix<Lanes>& F, const Trust<Lanes>& trust, const Lanes& converged,
                     LaneMatrix<Lanes>& R) {
  double trusted[2][kLanes];
  double done[kLanes];
  double in[9][kLanes];
  double out[9][kLanes];
  std::memcpy(trusted, &trust, sizeof trusted);
  std::memcpy(done, &converged, sizeof done);
  std::memcpy(in, &F, sizeof in);
  std::memcpy(out, &R, sizeof out);
  int inverted = 0;
  for (int n = 0; n < kLanes; ++n) {
    if (trusted[0][n] > 0.0 && trusted[1][n] > 0.0 && done[n] > 0.0) continue;
    Eigen::Matrix3d lane;
    for (int k = 0; k < 9; ++k) lane(k / 3, k % 3) = in[k][n];
    const PolarRotation polar = polar_rotation(lane);
    for (int k = 0; k < 9; ++k) out[k][n] = polar.R(k / 3, k % 3);
    inverted |= (polar.inverted ? 1 : 0) << n;
  }
  std::memcpy(&R, out, sizeof out);
  return inverted;
}

/// R = polar(F) per lane, by Newton's iteration R ← ½ (R + R⁻ᵀ) [Higham 1986]. Lanes with det F
/// near or below zero, or that do not converge, take polar_rotation(). Returns bit n for an
/// inverted lane n. Lanes are independent but for the number of iterations, which is that of the
/// slowest.
template <class Lanes>
TANDEM_INLINE int polar_lanes(const LaneMatrix<Lanes>& F, LaneMatrix<Lanes>& R) {
  LaneMatrix<Lanes> c;
  cofactor(F, c);
  Lanes square{};
  for (const Lanes& entry : F.at) square += entry * entry;
  Trust<Lanes> trust;
  trust.det = F.at[0] * c.at[0] + F.at[1] * c.at[1] + F.at[2] * c.at[2];
  // Squares compared: no root.
  constexpr double kFraction = kSingularFraction * kSingularFraction;
  trust.margin = trust.det * trust.det - kFraction * (square * square * square);
  const bool trusted = all_positive(trust.det) && all_positive(trust.margin);
  R = F;
  if (!trusted) replace_untrusted(trust, R);
  Lanes converged{};
  bool done = false;
  for (int step = 0; step < 12 && !done; ++step) {
    cofactor(R, c);
    const Lanes factor = 0.5 / (R.at[0] * c.at[0] + R.at[1] * c.at[1] + R.at[2] * c.at[2]);
    Lanes change{};
    for (int k = 0; k < 9; ++k) {
      const Lanes next = 0.5 * R.at[k] + factor * c.at[k];
      const Lanes difference = next - R.at[k];
      change += difference * difference;
      R.at[k] = next;
    }
    // Quadratic convergence: a step below 3e-9 ends within 1e-17 of the limit.
    converged = -(change - 1e-17);
    done = all_positive(converged);
  }
  return trusted && done ? 0 : repair_untrusted(F, trust, converged, R);
}

}  // namespace tandem::fem
