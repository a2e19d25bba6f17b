#pragma once

#include "fem_process/ancf/metric_lanes.h"
#include "fem_process/ancf/point_law.h"
#include "fem_process/ancf/point_stress.h"

namespace tandem::fem::ancf {

/// The laws of point_stress.h as functions of C and C' alone. Such a stress can take any C, also
/// one that belongs to no F, as assumed strains are.
/// The components of σ are conjugate to those of C, each once, σ·C' = ½ S:C': σ = ½ S on the
/// diagonal and S off it, S the second Piola-Kirchhoff stress.
struct MetricStress {
  LaneSymmetric sigma;
  LaneSix by_C;
  LaneSix by_rate;  ///< with respect to C'
};

/// S = m (I − I₁/3 V) + p V with m = μ J^(−2/3), I₁ = tr C, p = k J (J − 1), V = C⁻¹.
template <bool kTangent>
TANDEM_INLINE void add_neo_hookean(const PointLaw& law, const MetricPoint& point,
                                   const LaneMatrix& V, MetricStress& stress) {
  const Lanes J = point.J;
  Lanes m;
  power_minus_two_thirds(J, m);
  m *= law.mu;
  const Lanes third = m * (1.0 / 3.0) * (point.C.at[0] + point.C.at[1] + point.C.at[2]);
  const Lanes pressure = law.k * J * (J - 1.0);
  const Lanes along = 0.5 * (pressure - third);
  Lanes v[kSymmetric];
  for (int k = 0; k < kSymmetric; ++k) {
    v[k] = kTimes[k] * point.V.at[k];
    stress.sigma.at[k] += along * v[k];
  }
  for (int k = 0; k < 3; ++k) stress.sigma.at[k] += 0.5 * m;
  if constexpr (!kTangent) return;
  const Lanes dyad = third * (1.0 / 6.0) + (0.25 * law.k) * J * (2.0 * J - 1.0);
  const Lanes mixed = m * (1.0 / 6.0);
  for (int k = 0; k < kSymmetric; ++k) {
    for (int l = 0; l < kSymmetric; ++l) {
      Lanes sum = dyad * v[k] * v[l];
      if (k < 3) sum -= mixed * v[l];
      if (l < 3) sum -= mixed * v[k];
      stress.by_C.at[k][l] += sum;
    }
  }
  // dV = −V dC V.
  add_enclosed(-0.5 * along, V, V, stress.by_C);
}

/// S = a tr(X) I + b X + c diag(X) with X = ½ (C − I), or ½ C'.
template <bool kTangent>
TANDEM_INLINE void add_quadratic(double a, double b, double c, const LaneSymmetric& X,
                                 LaneSymmetric& sigma, LaneSix& T) {
  const Lanes trace = (0.5 * a) * (X.at[0] + X.at[1] + X.at[2]);
  for (int k = 0; k < 3; ++k) {
    sigma.at[k] += trace + (0.5 * (b + c)) * X.at[k];
    sigma.at[k + 3] += b * X.at[k + 3];
  }
  if constexpr (!kTangent) return;
  for (int k = 0; k < 3; ++k) {
    for (int l = 0; l < 3; ++l) T.at[k][l] += 0.25 * a;
    T.at[k][k] += 0.25 * (b + c);
    T.at[k + 3][k + 3] += 0.5 * b;
  }
}

/// S = J [(λ/2) (V:C') V + η V C' V], which is τ = J [λ tr D I + 2 η D] pulled back. With
/// Y = V C' V:
///   dS = ½ (V:dC) S − J [(λ/2) ((Y:dC) V + (V:C') V dC V) + η (V dC Y + Y dC V)]
///        + J [(λ/2) (V:dC') V + η V dC' V]
template <bool kTangent>
TANDEM_INLINE void add_spatial_viscosity(double lambda, double eta, const MetricPoint& point,
                                         const LaneMatrix& V, MetricStress& stress) {
  LaneMatrix rate;
  LaneMatrix Y;
  expand(point.rate, rate);
  enclose(V, rate, Y);
  Lanes dilatation = V.at[0] * rate.at[0];
  for (int n = 1; n < 9; ++n) dilatation += V.at[n] * rate.at[n];
  const Lanes bulk = (0.25 * lambda) * point.J;
  const Lanes shear = (0.5 * eta) * point.J;
  Lanes v[kSymmetric];
  Lanes y[kSymmetric];
  Lanes s[kSymmetric];
  for (int k = 0; k < kSymmetric; ++k) {
    v[k] = kTimes[k] * point.V.at[k];
    y[k] = kTimes[k] * Y.at[3 * kRowOf[k] + kColumnOf[k]];
    s[k] = bulk * dilatation * v[k] + shear * y[k];
    stress.sigma.at[k] += s[k];
  }
  if constexpr (!kTangent) return;
  for (int k = 0; k < kSymmetric; ++k) {
    for (int l = 0; l < kSymmetric; ++l) {
      stress.by_C.at[k][l] += 0.5 * s[k] * v[l] - bulk * v[k] * y[l];
      stress.by_rate.at[k][l] += bulk * v[k] * v[l];
    }
  }
  add_enclosed(-0.5 * bulk * dilatation, V, V, stress.by_C);
  add_enclosed(-shear, V, Y, stress.by_C);
  add_enclosed(0.5 * shear, V, V, stress.by_rate);
}

/// E = ½ (C − I).
TANDEM_INLINE void green_strain(const LaneSymmetric& C, LaneSymmetric& E) {
  for (int k = 0; k < kSymmetric; ++k) E.at[k] = 0.5 * (k < 3 ? C.at[k] - 1.0 : C.at[k]);
}

/// σ (Pa) and, if kTangent, its derivatives (all overwritten). V and J of `point` are used by the
/// neo-Hookean law and by the spatial viscosity.
template <bool kTangent>
TANDEM_INLINE void metric_stress(const PointLaw& law, const MetricPoint& point,
                                 MetricStress& stress) {
  stress.sigma = LaneSymmetric{};
  if constexpr (kTangent) {
    stress.by_C = LaneSix{};
    stress.by_rate = LaneSix{};
  }
  LaneMatrix V;
  expand(point.V, V);
  if (law.neo_hookean()) add_neo_hookean<kTangent>(law, point, V, stress);
  if (law.quadratic()) {
    LaneSymmetric E;
    green_strain(point.C, E);
    add_quadratic<kTangent>(law.trace, law.full, law.normal, E, stress.sigma, stress.by_C);
  }
  if (!law.viscous()) return;
  const double lambda = law.bulk_viscosity - 2.0 / 3.0 * law.shear_viscosity;
  if (law.viscosity == Viscosity::Spatial) {
    add_spatial_viscosity<kTangent>(lambda, law.shear_viscosity, point, V, stress);
    return;
  }
  LaneSymmetric E_rate;
  for (int k = 0; k < kSymmetric; ++k) E_rate.at[k] = 0.5 * point.rate.at[k];
  add_quadratic<kTangent>(lambda, 2.0 * law.shear_viscosity, 0.0, E_rate, stress.sigma,
                          stress.by_rate);
}

}  // namespace tandem::fem::ancf
