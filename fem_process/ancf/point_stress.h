#pragma once

#include <cmath>

#include "fem_process/ancf/lanes.h"
#include "fem_process/ancf/point_law.h"

namespace tandem::fem::ancf {

/// ∂P_iJ/∂F_kL + θ ∂P_iJ/∂F'_kL per lane, at [J][L][3 i + k].
struct LaneTangent {
  Lanes at[3][3][9];
};

/// Kinematics of a material point per lane.
struct LanePoint {
  LaneMatrix F;     ///< deformation gradient
  LaneMatrix rate;  ///< F' (1/s)
  LaneMatrix G;     ///< F⁻ᵀ
  Lanes J;          ///< det F
};

TANDEM_INLINE void power_minus_two_thirds(const Lanes& J, Lanes& power) {
  for (int n = 0; n < kLanes; ++n) {
    const double root = std::cbrt(J[n]);
    power[n] = 1.0 / (root * root);
  }
}

/// Fills G and J from F. Bit n of the result: lane n is turned inside out (J ≤ 0).
TANDEM_INLINE int invert(LanePoint& point) {
  cofactor(point.F, point.G);
  const Lanes* F = point.F.at;
  point.J = F[0] * point.G.at[0] + F[1] * point.G.at[1] + F[2] * point.G.at[2];
  for (Lanes& entry : point.G.at) entry /= point.J;
  int inverted = 0;
  for (int n = 0; n < kLanes; ++n) inverted |= (point.J[n] > 0.0 ? 0 : 1) << n;
  return inverted;
}

/// c = a bᵀ.
TANDEM_INLINE void times_transposed(const LaneMatrix& a, const LaneMatrix& b, LaneMatrix& c) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      c.at[3 * i + j] = a.at[3 * i] * b.at[3 * j] + a.at[3 * i + 1] * b.at[3 * j + 1] +
                        a.at[3 * i + 2] * b.at[3 * j + 2];
    }
  }
}

/// c = aᵀ b.
TANDEM_INLINE void transposed_times(const LaneMatrix& a, const LaneMatrix& b, LaneMatrix& c) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      c.at[3 * i + j] = a.at[i] * b.at[j] + a.at[3 + i] * b.at[3 + j] + a.at[6 + i] * b.at[6 + j];
    }
  }
}

/// c = a b.
TANDEM_INLINE void times(const LaneMatrix& a, const LaneMatrix& b, LaneMatrix& c) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      c.at[3 * i + j] =
          a.at[3 * i] * b.at[j] + a.at[3 * i + 1] * b.at[3 + j] + a.at[3 * i + 2] * b.at[6 + j];
    }
  }
}

TANDEM_INLINE void contract(const LaneMatrix& a, const LaneMatrix& b, Lanes& sum) {
  sum = a.at[0] * b.at[0];
  for (int k = 1; k < 9; ++k) sum += a.at[k] * b.at[k];
}

/// Adds c1 A_iL B_kJ and such terms: T_iJkL += cross_iL G_kJ + G_iJ right_kL + left_iJ G_kL.
TANDEM_INLINE void add_dyads(const LaneMatrix& G, const LaneMatrix& cross, const LaneMatrix& right,
                             const LaneMatrix& left, LaneTangent& T) {
  for (int J = 0; J < 3; ++J) {
    for (int L = 0; L < 3; ++L) {
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          T.at[J][L][3 * i + k] += cross.at[3 * i + L] * G.at[3 * k + J] +
                                   G.at[3 * i + J] * right.at[3 * k + L] +
                                   left.at[3 * i + J] * G.at[3 * k + L];
        }
      }
    }
  }
}

/// With m = μ J^(−2/3), I = tr FᵀF:
///   T_iJkL = m δ_ik δ_JL + (m I/3 − k J (J − 1)) G_iL G_kJ − (2/3) m (F_iJ G_kL + G_iJ F_kL)
///            + ((2/9) m I + k J (2 J − 1)) G_iJ G_kL
template <bool kTangent>
TANDEM_INLINE void add_neo_hookean(const PointLaw& law, const LanePoint& point, LaneMatrix& P,
                                   LaneTangent& T) {
  const Lanes J = point.J;
  Lanes m;
  power_minus_two_thirds(J, m);
  m *= law.mu;
  Lanes third;
  contract(point.F, point.F, third);
  third *= m * (1.0 / 3.0);
  const Lanes pressure = law.k * J * (J - 1.0);
  for (int n = 0; n < 9; ++n) {
    P.at[n] += m * point.F.at[n] + (pressure - third) * point.G.at[n];
  }
  if constexpr (!kTangent) return;
  const Lanes dyad = third * (2.0 / 3.0) + law.k * J * (2.0 * J - 1.0);
  const Lanes mixed = m * (2.0 / 3.0);
  LaneMatrix cross;
  LaneMatrix right;
  LaneMatrix left;
  for (int n = 0; n < 9; ++n) {
    cross.at[n] = (third - pressure) * point.G.at[n];
    right.at[n] = dyad * point.G.at[n] - mixed * point.F.at[n];
    left.at[n] = -mixed * point.F.at[n];
  }
  add_dyads(point.G, cross, right, left, T);
  for (int J2 = 0; J2 < 3; ++J2) {
    for (int i = 0; i < 3; ++i) T.at[J2][J2][4 * i] += m;
  }
}

/// P = F S and its derivative for S = a tr(X) I + b X + c diag(X), X = sym(Fᵀ B) up to a constant:
///   T_iJkL = δ_ik S_JL + a F_iJ B_kL + (b/2) ((F Bᵀ)_ik δ_JL + F_iL B_kJ) + c δ_JL F_iJ B_kJ
/// Elastic: B = F, X = E. Viscous: B = θ F + F' and X = E'.
template <bool kTangent>
TANDEM_INLINE void add_second_piola(double a, double b, double c, const LaneMatrix& F,
                                    const LaneMatrix& X, const LaneMatrix& B, LaneMatrix& P,
                                    LaneTangent& T) {
  const Lanes trace = a * (X.at[0] + X.at[4] + X.at[8]);
  LaneMatrix S;
  for (int n = 0; n < 9; ++n) S.at[n] = b * X.at[n];
  for (int n = 0; n < 9; n += 4) S.at[n] += trace + c * X.at[n];
  LaneMatrix stress;
  times(F, S, stress);
  for (int n = 0; n < 9; ++n) P.at[n] += stress.at[n];
  if constexpr (!kTangent) return;
  LaneMatrix FB;
  times_transposed(F, B, FB);
  for (int J = 0; J < 3; ++J) {
    for (int L = 0; L < 3; ++L) {
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          T.at[J][L][3 * i + k] +=
              a * F.at[3 * i + J] * B.at[3 * k + L] + (0.5 * b) * F.at[3 * i + L] * B.at[3 * k + J];
        }
        T.at[J][L][4 * i] += S.at[3 * J + L];
      }
    }
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        T.at[J][J][3 * i + k] +=
            (0.5 * b) * FB.at[3 * i + k] + c * F.at[3 * i + J] * B.at[3 * k + J];
      }
    }
  }
}

/// τ = J [λ tr L I + η (L + Lᵀ)], L = F' F⁻¹, P = τ F⁻ᵀ. With A = θ I − L and M = Aᵀ G:
///   T_iJkL = J λ G_iJ M_kL + J η (A_ik (GᵀG)_LJ + G_iL M_kJ) + P_iJ G_kL − P_iL G_kJ
template <bool kTangent>
TANDEM_INLINE void add_spatial_viscosity(double lambda, double eta, double theta,
                                         const LanePoint& point, LaneMatrix& P, LaneTangent& T) {
  LaneMatrix L;
  times_transposed(point.rate, point.G, L);
  const Lanes pressure = lambda * point.J * (L.at[0] + L.at[4] + L.at[8]);
  const Lanes shear = eta * point.J;
  LaneMatrix tau;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) tau.at[3 * i + j] = shear * (L.at[3 * i + j] + L.at[3 * j + i]);
    tau.at[4 * i] += pressure;
  }
  LaneMatrix stress;
  times(tau, point.G, stress);
  for (int n = 0; n < 9; ++n) P.at[n] += stress.at[n];
  if constexpr (!kTangent) return;
  LaneMatrix A;
  for (int n = 0; n < 9; ++n) A.at[n] = (n % 4 == 0 ? theta : 0.0) - L.at[n];
  LaneMatrix M;
  transposed_times(A, point.G, M);
  LaneMatrix Q;
  transposed_times(point.G, point.G, Q);
  LaneMatrix right;
  LaneMatrix cross;
  for (int n = 0; n < 9; ++n) {
    right.at[n] = (lambda * point.J) * M.at[n];
    cross.at[n] = -stress.at[n];
  }
  add_dyads(point.G, cross, right, stress, T);
  for (int J = 0; J < 3; ++J) {
    for (int K = 0; K < 3; ++K) {
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          T.at[J][K][3 * i + k] +=
              shear * (A.at[3 * i + k] * Q.at[3 * K + J] + point.G.at[3 * i + K] * M.at[3 * k + J]);
        }
      }
    }
  }
}

/// E = ½ (FᵀF − I).
TANDEM_INLINE void green_strain(const LaneMatrix& F, LaneMatrix& E) {
  transposed_times(F, F, E);
  for (int n = 0; n < 9; ++n) E.at[n] = 0.5 * (E.at[n] - (n % 4 == 0 ? 1.0 : 0.0));
}

/// First Piola-Kirchhoff stress P (Pa) and, if kTangent, T = ∂P/∂F + θ ∂P/∂F' (both overwritten).
/// G and J of `point` are used by the neo-Hookean law and by the spatial viscosity.
template <bool kTangent>
TANDEM_INLINE void point_stress(const PointLaw& law, double theta, const LanePoint& point,
                                LaneMatrix& P, LaneTangent& T) {
  P = LaneMatrix{};
  if constexpr (kTangent) T = LaneTangent{};
  if (law.neo_hookean()) add_neo_hookean<kTangent>(law, point, P, T);
  if (law.quadratic()) {
    LaneMatrix E;
    green_strain(point.F, E);
    add_second_piola<kTangent>(law.trace, law.full, law.normal, point.F, E, point.F, P, T);
  }
  if (!law.viscous()) return;
  const double lambda = law.bulk_viscosity - 2.0 / 3.0 * law.shear_viscosity;
  if (law.viscosity == Viscosity::Spatial) {
    add_spatial_viscosity<kTangent>(lambda, law.shear_viscosity, theta, point, P, T);
    return;
  }
  LaneMatrix product;
  transposed_times(point.F, point.rate, product);
  LaneMatrix E_rate;
  LaneMatrix B;
  for (int n = 0; n < 9; ++n) {
    E_rate.at[n] = 0.5 * (product.at[n] + product.at[3 * (n % 3) + n / 3]);
    B.at[n] = theta * point.F.at[n] + point.rate.at[n];
  }
  add_second_piola<kTangent>(lambda, 2.0 * law.shear_viscosity, 0.0, point.F, E_rate, B, P, T);
}

/// Elastic energy per stress-free volume W (J/m³), from E: small strains do not cancel.
///   J² − 1 = det(I + 2E) − 1,   J^(−2/3) tr FᵀF − 3 = (J^(−2/3) − 1)(3 + 2 tr E) + 2 tr E
TANDEM_INLINE void energy_density(const PointLaw& law, const LaneMatrix& E, Lanes& W) {
  const Lanes trace = E.at[0] + E.at[4] + E.at[8];
  Lanes square;
  contract(E, E, square);
  W = (0.5 * law.trace) * trace * trace + (0.5 * law.full) * square +
      (0.5 * law.normal) * (E.at[0] * E.at[0] + E.at[4] * E.at[4] + E.at[8] * E.at[8]);
  if (!law.neo_hookean()) return;
  LaneMatrix cofactors;
  cofactor(E, cofactors);
  const Lanes* e = E.at;
  const Lanes determinant =
      e[0] * cofactors.at[0] + e[1] * cofactors.at[1] + e[2] * cofactors.at[2];
  const Lanes growth = 2.0 * trace + 2.0 * (trace * trace - square) + 8.0 * determinant;
  for (int n = 0; n < kLanes; ++n) {
    const double isochoric = std::expm1(-std::log1p(growth[n]) / 3.0);
    const double volumetric = growth[n] / (1.0 + std::sqrt(1.0 + growth[n]));
    W[n] += 0.5 * law.mu * (isochoric * (3.0 + 2.0 * trace[n]) + 2.0 * trace[n]) +
            0.5 * law.k * volumetric * volumetric;
  }
}

}  // namespace tandem::fem::ancf
