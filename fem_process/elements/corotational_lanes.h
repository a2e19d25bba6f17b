#pragma once

#include "fem_process/kernels/polar_lanes.h"
#include "fem_process/kernels/simd.h"

namespace tandem::fem {

/// Rᵀ F per lane, row by row.
template <class Lanes>
TANDEM_INLINE void turn_back(const LaneMatrix<Lanes>& R, const LaneMatrix<Lanes>& F,
                             Lanes (&A)[9]) {
  for (int k = 0; k < 9; ++k) {
    const int i = k / 3;
    const int j = k % 3;
    A[k] = R.at[i] * F.at[j] + R.at[3 + i] * F.at[3 + j] + R.at[6 + i] * F.at[6 + j];
  }
}

/// V σ (N m) of isotropic co-rotated material per lane, symmetric, row by row, in the turned axes:
///   σ = λ tr ε I + 2 μ ε,  ε = sym A − I,  A = Rᵀ F.
template <class Lanes>
TANDEM_INLINE void corotated_stress(const Lanes (&A)[9], const Lanes& volume, double lambda,
                                    double mu, Lanes (&sigma)[9]) {
  const Lanes e0 = A[0] - 1.0;
  const Lanes e1 = A[4] - 1.0;
  const Lanes e2 = A[8] - 1.0;
  const Lanes pressure = lambda * volume * (e0 + e1 + e2);
  const Lanes twice = (2.0 * mu) * volume;
  const Lanes shear = mu * volume;
  sigma[0] = pressure + twice * e0;
  sigma[4] = pressure + twice * e1;
  sigma[8] = pressure + twice * e2;
  sigma[1] = sigma[3] = shear * (A[1] + A[3]);
  sigma[5] = sigma[7] = shear * (A[5] + A[7]);
  sigma[2] = sigma[6] = shear * (A[2] + A[6]);
}

/// Row a of V P = R V σ.
template <class Lanes>
TANDEM_INLINE void turned_row(const LaneMatrix<Lanes>& R, const Lanes (&sigma)[9], int a,
                              Lanes (&P)[3]) {
  for (int b = 0; b < 3; ++b) {
    P[b] = R.at[3 * a] * sigma[b] + R.at[3 * a + 1] * sigma[3 + b] + R.at[3 * a + 2] * sigma[6 + b];
  }
}

}  // namespace tandem::fem
