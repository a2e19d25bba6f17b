#pragma once

#include "fem_process/kernels/simd.h"

namespace tandem::fem {

/// The block of three rows, 9 numbers; each row's fourth lane is thrown away.
TANDEM_INLINE void store_block(const Double4& a, const Double4& b, const Double4& c, double* to) {
  store(a, to);
  store(b, to + 3);
  // The last row with the number before it: no write behind the block.
  const Double4 last = __builtin_shufflevector(b, c, 2, 4, 5, 6);
  store(last, to + 5);
}

/// λ D + μ Dᵀ + μ tr D I into block `to`, its transpose into `transposed` unless that is null.
TANDEM_INLINE void store_stiffness(const Double4 (&D)[3], double lambda, double mu, double* to,
                                   double* transposed) {
  Double4 T[4] = {D[0], D[1], D[2], Double4{}};
  transpose(T[0], T[1], T[2], T[3]);
  const double trace = mu * (D[0][0] + D[1][1] + D[2][2]);
  const Double4 unit[3] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  Double4 K[3];
  for (int r = 0; r < 3; ++r) K[r] = lambda * D[r] + mu * T[r] + trace * unit[r];
  store_block(K[0], K[1], K[2], to);
  if (transposed == nullptr) return;
  for (int r = 0; r < 3; ++r) K[r] = lambda * T[r] + mu * D[r] + trace * unit[r];
  store_block(K[0], K[1], K[2], transposed);
}

}  // namespace tandem::fem
