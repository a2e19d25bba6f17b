#pragma once

#include <cmath>

#include "fem_process/ancf/lanes.h"

namespace tandem::fem::ancf {

/// Components of a symmetric tensor, each once: xx, yy, zz, xy, xz, yz.
inline constexpr int kSymmetric = 6;
inline constexpr int kRowOf[kSymmetric] = {0, 1, 2, 0, 0, 1};
inline constexpr int kColumnOf[kSymmetric] = {0, 1, 2, 1, 2, 2};
/// How often a component stands in the tensor.
inline constexpr double kTimes[kSymmetric] = {1.0, 1.0, 1.0, 2.0, 2.0, 2.0};

struct LaneSymmetric {
  Lanes at[kSymmetric];
};
/// Derivatives of six components with respect to six.
struct LaneSix {
  Lanes at[kSymmetric][kSymmetric];
};

/// A material point seen from its right Cauchy-Green tensor C = FᵀF.
struct MetricPoint {
  LaneSymmetric C;
  LaneSymmetric rate;  ///< C' (1/s)
  LaneSymmetric V;     ///< C⁻¹
  Lanes J;             ///< √det C
};

TANDEM_INLINE void expand(const LaneSymmetric& from, LaneMatrix& to) {
  constexpr int kAt[9] = {0, 3, 4, 3, 1, 5, 4, 5, 2};
  for (int n = 0; n < 9; ++n) to.at[n] = from.at[kAt[n]];
}

/// Fills V and J. Bit n of the result: lane n has no positive det C.
TANDEM_INLINE int invert(MetricPoint& point) {
  const Lanes* c = point.C.at;
  Lanes* v = point.V.at;
  v[0] = c[1] * c[2] - c[5] * c[5];
  v[1] = c[0] * c[2] - c[4] * c[4];
  v[2] = c[0] * c[1] - c[3] * c[3];
  v[3] = c[4] * c[5] - c[3] * c[2];
  v[4] = c[3] * c[5] - c[4] * c[1];
  v[5] = c[3] * c[4] - c[0] * c[5];
  const Lanes determinant = c[0] * v[0] + c[3] * v[3] + c[4] * v[4];
  int inverted = 0;
  for (int n = 0; n < kLanes; ++n) {
    inverted |= (determinant[n] > 0.0 ? 0 : 1) << n;
    point.J[n] = std::sqrt(determinant[n]);
  }
  const Lanes inverse = 1.0 / determinant;
  for (int k = 0; k < kSymmetric; ++k) v[k] *= inverse;
  return inverted;
}

/// V X V.
TANDEM_INLINE void enclose(const LaneMatrix& V, const LaneMatrix& X, LaneMatrix& product) {
  Lanes half[9];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      half[3 * i + j] =
          V.at[3 * i] * X.at[j] + V.at[3 * i + 1] * X.at[3 + j] + V.at[3 * i + 2] * X.at[6 + j];
    }
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      product.at[3 * i + j] =
          half[3 * i] * V.at[j] + half[3 * i + 1] * V.at[3 + j] + half[3 * i + 2] * V.at[6 + j];
    }
  }
}

/// T += factor · ∂(A dC B + B dC A)/∂C, each row as often as its component stands in the tensor.
TANDEM_INLINE void add_enclosed(const Lanes& factor, const LaneMatrix& A, const LaneMatrix& B,
                                LaneSix& T) {
#pragma GCC unroll 6
  for (int k = 0; k < kSymmetric; ++k) {
    const int i = 3 * kRowOf[k];
    const int j = 3 * kColumnOf[k];
    const Lanes weight = factor * kTimes[k];
#pragma GCC unroll 6
    for (int l = 0; l < kSymmetric; ++l) {
      const int a = kRowOf[l];
      const int b = kColumnOf[l];
      Lanes sum = A.at[i + a] * B.at[j + b] + B.at[i + a] * A.at[j + b];
      if (a != b) sum += A.at[i + b] * B.at[j + a] + B.at[i + b] * A.at[j + a];
      T.at[k][l] += weight * sum;
    }
  }
}

/// The components in other axes: C ← Tᵀ C T as six numbers from six, M.
TANDEM_INLINE void turning(const LaneMatrix& T, LaneSix& M) {
#pragma GCC unroll 6
  for (int k = 0; k < kSymmetric; ++k) {
    const int i = kRowOf[k];
    const int j = kColumnOf[k];
#pragma GCC unroll 6
    for (int l = 0; l < kSymmetric; ++l) {
      const int a = 3 * kRowOf[l];
      const int b = 3 * kColumnOf[l];
      M.at[k][l] = T.at[a + i] * T.at[b + j];
      if (a != b) M.at[k][l] += T.at[b + i] * T.at[a + j];
    }
  }
}

TANDEM_INLINE void turn(const LaneSix& M, LaneSymmetric& x) {
  const LaneSymmetric before = x;
  for (int k = 0; k < kSymmetric; ++k) {
    x.at[k] = M.at[k][0] * before.at[0];
    for (int l = 1; l < kSymmetric; ++l) x.at[k] += M.at[k][l] * before.at[l];
  }
}

/// Mᵀ x.
TANDEM_INLINE void turn_back(const LaneSix& M, LaneSymmetric& x) {
  const LaneSymmetric before = x;
  for (int k = 0; k < kSymmetric; ++k) {
    x.at[k] = M.at[0][k] * before.at[0];
    for (int l = 1; l < kSymmetric; ++l) x.at[k] += M.at[l][k] * before.at[l];
  }
}

/// Mᵀ T M.
TANDEM_INLINE void turn_back(const LaneSix& M, LaneSix& T) {
  LaneSix half;
  for (int k = 0; k < kSymmetric; ++k) {
    for (int l = 0; l < kSymmetric; ++l) {
      half.at[k][l] = T.at[k][0] * M.at[0][l];
      for (int n = 1; n < kSymmetric; ++n) half.at[k][l] += T.at[k][n] * M.at[n][l];
    }
  }
  for (int k = 0; k < kSymmetric; ++k) {
    for (int l = 0; l < kSymmetric; ++l) {
      T.at[k][l] = M.at[0][k] * half.at[0][l];
      for (int n = 1; n < kSymmetric; ++n) T.at[k][l] += M.at[n][k] * half.at[n][l];
    }
  }
}

}  // namespace tandem::fem::ancf
