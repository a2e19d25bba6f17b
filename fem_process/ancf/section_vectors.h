#pragma once

#include "fem_process/ancf/beam_shape.h"
#include "fem_process/ancf/lanes.h"

namespace tandem::fem::ancf {

/// The vectors of a section, in the order t = r_x, a = r_y, b = r_z of the axis, a' = ∂a/∂x,
/// b' = ∂b/∂x: F = [t + y a' + z b' | a | b].
inline constexpr int kSection = 5;

/// Which section vectors a slot of an element enters, and with which factors at a station.
struct Spread {
  Lanes factor[kVectors];  ///< to kFirst
  Lanes second[kVectors];  ///< to kSecond where that is not negative
};
inline constexpr int kFirst[kVectors] = {0, 0, 1, 2, 0, 0, 1, 2};
inline constexpr int kSecond[kVectors] = {-1, -1, 3, 4, -1, -1, 3, 4};

TANDEM_INLINE void spread_at(double xi, const Lanes& length, Spread& spread) {
  const Lanes inverse = 1.0 / length;
  const Lanes none{};
  spread.factor[0] = (6.0 * (xi * xi - xi)) * inverse;
  spread.factor[4] = -spread.factor[0];
  spread.factor[1] = none + (1.0 - 4.0 * xi + 3.0 * xi * xi);
  spread.factor[5] = none + (3.0 * xi * xi - 2.0 * xi);
  for (int slot = 2; slot < 4; ++slot) {
    spread.factor[slot] = none + (1.0 - xi);
    spread.factor[slot + 4] = none + xi;
    spread.second[slot] = -inverse;
    spread.second[slot + 4] = inverse;
  }
}

TANDEM_INLINE void section_vectors(const Spread& spread, const Lanes* e, Lanes (&u)[kSection][3]) {
  for (int i = 0; i < 3; ++i) {
    for (int s = 0; s < kSection; ++s) u[s][i] = Lanes{};
    for (int slot = 0; slot < kVectors; ++slot) {
      u[kFirst[slot]][i] += spread.factor[slot] * e[3 * slot + i];
      if (kSecond[slot] >= 0) u[kSecond[slot]][i] += spread.second[slot] * e[3 * slot + i];
    }
  }
}

/// Resultants of a section: forces that belong to the section vectors, and their derivatives.
struct Resultants {
  Lanes force[kSection][3];
  Lanes tangent[kSection][kSection][9];
};

TANDEM_INLINE void spread_force(const Spread& spread, const Resultants& sum, Lanes* f) {
  for (int slot = 0; slot < kVectors; ++slot) {
    for (int i = 0; i < 3; ++i) {
      f[3 * slot + i] += spread.factor[slot] * sum.force[kFirst[slot]][i];
      if (kSecond[slot] >= 0) {
        f[3 * slot + i] += spread.second[slot] * sum.force[kSecond[slot]][i];
      }
    }
  }
}

TANDEM_INLINE void spread_tangent(const Spread& spread, const Resultants& sum, Lanes* K) {
  Lanes columns[kSection][kVectors][9];
  for (int s = 0; s < kSection; ++s) {
    for (int slot = 0; slot < kVectors; ++slot) {
      for (int n = 0; n < 9; ++n) {
        columns[s][slot][n] = spread.factor[slot] * sum.tangent[s][kFirst[slot]][n];
        if (kSecond[slot] >= 0) {
          columns[s][slot][n] += spread.second[slot] * sum.tangent[s][kSecond[slot]][n];
        }
      }
    }
  }
  for (int row = 0; row < kVectors; ++row) {
    for (int slot = 0; slot < kVectors; ++slot) {
      for (int i = 0; i < 3; ++i) {
        Lanes* out = K + (3 * row + i) * kCoordinates + 3 * slot;
        for (int k = 0; k < 3; ++k) {
          out[k] += spread.factor[row] * columns[kFirst[row]][slot][3 * i + k];
          if (kSecond[row] >= 0) {
            out[k] += spread.second[row] * columns[kSecond[row]][slot][3 * i + k];
          }
        }
      }
    }
  }
}

/// The numbers of the lanes that are in use, one element after the other.
TANDEM_INLINE void store(const Lanes* lanes, int entries, int count, double* out) {
  for (int n = 0; n < count; ++n) {
    for (int k = 0; k < entries; ++k) out[n * entries + k] = lanes[k][n];
  }
}

}  // namespace tandem::fem::ancf
