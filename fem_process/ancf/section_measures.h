#pragma once

#include "fem_process/ancf/metric_stress.h"
#include "fem_process/ancf/section_vectors.h"

namespace tandem::fem::ancf {

/// Assumed strains of a section (Strain::Assumed). With the section vectors t, a, b, a', b' and the
/// length l, the covariant components of C at a point (y, z) of the station ξ are
///   C_xx = t·t + 2 y t·a' + 2 z t·b' + y² a'·a' + 2 y z a'·b' + z² b'·b'
///   C_xy = t·a + y a·a' + z a·b'       C_yy = a·a + c a'·a'      c = l² ξ (1 − ξ)
///   C_xz = t·b + y b·a' + z b·b'       C_zz = b·b + c b'·b'
///                                      C_yz = a·b + c a'·b'
/// a and b being linear in ξ, the terms with c make C_yy, C_zz and C_yz linear between the nodes:
///   |(1−ξ) a¹ + ξ a²|² + ξ (1−ξ) |a² − a¹|² = (1−ξ) |a¹|² + ξ |a²|²
/// All are products of section vectors, so the section is summed up to forces and stiffnesses that
/// belong to fifteen measures, each of which stands in one component with one weight of (y, z).
inline constexpr int kMeasures = 15;

/// The component of C that a measure stands in.
inline constexpr int kComponent[kMeasures] = {0, 0, 0, 0, 0, 0, 3, 3, 3, 4, 4, 4, 1, 2, 5};

/// Its weight at a point.
TANDEM_INLINE void measure_weights(double y, double z, double (&weight)[kMeasures]) {
  const double all[kMeasures] = {1.0, y,   z, y * y, y * z, z * z, 1.0, y,
                                 z,   1.0, y, z,     1.0,   1.0,   1.0};
  for (int m = 0; m < kMeasures; ++m) weight[m] = all[m];
}

/// A product of two section vectors in a measure.
struct Product {
  int measure, first, second;
  double factor;
};
inline constexpr int kProducts = 15;
inline constexpr Product kProduct[kProducts] = {
    {0, 0, 0, 1.0},  {1, 0, 3, 2.0},  {2, 0, 4, 2.0},  {3, 3, 3, 1.0},  {4, 3, 4, 2.0},
    {5, 4, 4, 1.0},  {6, 0, 1, 1.0},  {7, 1, 3, 1.0},  {8, 1, 4, 1.0},  {9, 0, 2, 1.0},
    {10, 2, 3, 1.0}, {11, 2, 4, 1.0}, {12, 1, 1, 1.0}, {13, 2, 2, 1.0}, {14, 1, 2, 1.0}};
/// Those with the factor c.
inline constexpr int kSags = 3;
inline constexpr Product kSag[kSags] = {{12, 3, 3, 1.0}, {13, 4, 4, 1.0}, {14, 3, 4, 1.0}};

/// Section vectors, their rates, and c.
struct SectionState {
  Lanes u[kSection][3];
  Lanes rate[kSection][3];
  Lanes sag;
  bool sags = false;  ///< c is not zero: between the nodes
};

/// Calls use(product, factor) for all products.
template <class Use>
TANDEM_INLINE void for_each_product(const SectionState& section, const Use& use) {
#pragma GCC unroll 15
  for (int n = 0; n < kProducts; ++n) use(kProduct[n], Lanes{} + kProduct[n].factor);
  if (!section.sags) return;
#pragma GCC unroll 3
  for (int n = 0; n < kSags; ++n) use(kSag[n], section.sag * kSag[n].factor);
}

TANDEM_INLINE void dot(const Lanes (&a)[3], const Lanes (&b)[3], Lanes& product) {
  product = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Measures and their rates.
struct Measures {
  Lanes value[kMeasures];
  Lanes rate[kMeasures];
};
TANDEM_INLINE void measure(const SectionState& section, Measures& measures) {
  measures = Measures{};
  for_each_product(section, [&](const Product& p, const Lanes& factor) {
    Lanes product;
    dot(section.u[p.first], section.u[p.second], product);
    measures.value[p.measure] += factor * product;
    Lanes before;
    dot(section.rate[p.first], section.u[p.second], before);
    dot(section.u[p.first], section.rate[p.second], product);
    measures.rate[p.measure] += factor * (before + product);
  });
}

TANDEM_INLINE void metric_at(const Lanes (&measures)[kMeasures], const double (&weight)[kMeasures],
                             LaneSymmetric& C) {
  C = LaneSymmetric{};
#pragma GCC unroll 15
  for (int m = 0; m < kMeasures; ++m) C.at[kComponent[m]] += weight[m] * measures[m];
}

/// What belongs to the measures: forces, and stiffnesses by the measures and by their rates.
struct MeasureSums {
  Lanes force[kMeasures];
  Lanes by_value[kMeasures][kMeasures];
  Lanes by_rate[kMeasures][kMeasures];
};

template <bool kTangent>
TANDEM_INLINE void add_point(const Lanes& volume, const double (&weight)[kMeasures], bool viscous,
                             const MetricStress& stress, MeasureSums& sums) {
  for (int m = 0; m < kMeasures; ++m) {
    const Lanes w = volume * weight[m];
    sums.force[m] += w * stress.sigma.at[kComponent[m]];
    if constexpr (!kTangent) continue;
    for (int n = 0; n < kMeasures; ++n) {
      sums.by_value[m][n] += (w * weight[n]) * stress.by_C.at[kComponent[m]][kComponent[n]];
    }
    if (!viscous) continue;
    for (int n = 0; n < kMeasures; ++n) {
      sums.by_rate[m][n] += (w * weight[n]) * stress.by_rate.at[kComponent[m]][kComponent[n]];
    }
  }
}

/// A section vector in a measure: the measure changes by factor · other·δu, times c if `sags`.
struct Arm {
  int measure, other;
  double factor;
  bool sags = false;
};
inline constexpr int kMostArms = 7;
/// The arms of a vector lie from here to before those of the next.
inline constexpr int kFirstArm[kSection + 1] = {0, 5, 10, 15, 22, 29};
inline constexpr int kArms = kFirstArm[kSection];
inline constexpr Arm kArm[kArms] = {
    {0, 0, 2.0},        {1, 3, 2.0},        {2, 4, 2.0},  {6, 1, 1.0},  {9, 2, 1.0},   // t
    {6, 0, 1.0},        {7, 3, 1.0},        {8, 4, 1.0},  {12, 1, 2.0}, {14, 2, 1.0},  // a
    {9, 0, 1.0},        {10, 3, 1.0},       {11, 4, 1.0}, {13, 2, 2.0}, {14, 1, 1.0},  // b
    {1, 0, 2.0},        {3, 3, 2.0},        {4, 4, 2.0},  {7, 1, 1.0},  {10, 2, 1.0},  // a'
    {12, 3, 2.0, true}, {14, 4, 1.0, true},                                            //
    {2, 0, 2.0},        {4, 3, 2.0},        {5, 4, 2.0},  {8, 1, 1.0},  {11, 2, 1.0},  // b'
    {13, 4, 2.0, true}, {14, 3, 1.0, true}};

/// ∂ measure/∂ section vector, arm by arm.
struct ArmSlopes {
  Lanes of[kArms][3];
};
TANDEM_INLINE void slopes_of(const Lanes (&u)[kSection][3], const Lanes& sag, ArmSlopes& slopes) {
#pragma GCC unroll 29
  for (int n = 0; n < kArms; ++n) {
    const Lanes factor = kArm[n].sags ? kArm[n].factor * sag : Lanes{} + kArm[n].factor;
    for (int i = 0; i < 3; ++i) slopes.of[n][i] = factor * u[kArm[n].other][i];
  }
}

/// Changes of a measure's force with a section vector, from the row of its stiffness.
template <int kVector>
TANDEM_INLINE void add_change(const Lanes (&stiffness)[kMeasures], const ArmSlopes& slopes,
                              Lanes (&change)[kSection][3]) {
  constexpr int kBegin = kFirstArm[kVector];
  constexpr int kEnd = kFirstArm[kVector + 1];
  Lanes x = change[kVector][0];
  Lanes y = change[kVector][1];
  Lanes z = change[kVector][2];
#pragma GCC unroll 7
  for (int n = kBegin; n < kEnd; ++n) {
    x += stiffness[kArm[n].measure] * slopes.of[n][0];
    y += stiffness[kArm[n].measure] * slopes.of[n][1];
    z += stiffness[kArm[n].measure] * slopes.of[n][2];
  }
  change[kVector][0] = x;
  change[kVector][1] = y;
  change[kVector][2] = z;
}
TANDEM_INLINE void add_changes(const Lanes (&stiffness)[kMeasures], const ArmSlopes& slopes,
                               Lanes (&change)[kSection][3]) {
  add_change<0>(stiffness, slopes, change);
  add_change<1>(stiffness, slopes, change);
  add_change<2>(stiffness, slopes, change);
  add_change<3>(stiffness, slopes, change);
  add_change<4>(stiffness, slopes, change);
}

/// The tangents of a section vector's force.
template <int kVector>
TANDEM_INLINE void add_tangents(const ArmSlopes& slopes,
                                const Lanes (&change)[kMeasures][kSection][3], Resultants& out) {
  constexpr int kBegin = kFirstArm[kVector];
  constexpr int kEnd = kFirstArm[kVector + 1];
  for (int r = 0; r < kSection; ++r) {
    Lanes* to = out.tangent[kVector][r];
    for (int i = 0; i < 3; ++i) {
      Lanes x = to[3 * i];
      Lanes y = to[3 * i + 1];
      Lanes z = to[3 * i + 2];
#pragma GCC unroll 7
      for (int n = kBegin; n < kEnd; ++n) {
        x += slopes.of[n][i] * change[kArm[n].measure][r][0];
        y += slopes.of[n][i] * change[kArm[n].measure][r][1];
        z += slopes.of[n][i] * change[kArm[n].measure][r][2];
      }
      to[3 * i] = x;
      to[3 * i + 1] = y;
      to[3 * i + 2] = z;
    }
  }
}

/// Forces and tangents that belong to the section vectors. A measure Σ factor u_p·u_q changes by
/// Σ factor (u_q·δu_p + u_p·δu_q), its rate by the same of u' + θ u in place of u.
template <bool kTangent>
TANDEM_INLINE void to_vectors(const SectionState& section, double theta, bool viscous,
                              const MeasureSums& sums, Resultants& out) {
  for_each_product(section, [&](const Product& p, const Lanes& factor) {
    const Lanes force = factor * sums.force[p.measure];
    for (int i = 0; i < 3; ++i) {
      out.force[p.first][i] += force * section.u[p.second][i];
      out.force[p.second][i] += force * section.u[p.first][i];
      if constexpr (!kTangent) continue;
      out.tangent[p.first][p.second][4 * i] += force;
      out.tangent[p.second][p.first][4 * i] += force;
    }
  });
  if constexpr (!kTangent) return;
  ArmSlopes slopes;
  slopes_of(section.u, section.sag, slopes);
  Lanes change[kMeasures][kSection][3] = {};
  for (int m = 0; m < kMeasures; ++m) add_changes(sums.by_value[m], slopes, change[m]);
  if (viscous) {
    Lanes moved[kSection][3];
    for (int s = 0; s < kSection; ++s) {
      for (int i = 0; i < 3; ++i) moved[s][i] = section.rate[s][i] + theta * section.u[s][i];
    }
    ArmSlopes rates;
    slopes_of(moved, section.sag, rates);
    for (int m = 0; m < kMeasures; ++m) add_changes(sums.by_rate[m], rates, change[m]);
  }
  add_tangents<0>(slopes, change, out);
  add_tangents<1>(slopes, change, out);
  add_tangents<2>(slopes, change, out);
  add_tangents<3>(slopes, change, out);
  add_tangents<4>(slopes, change, out);
}

/// Bits of the lanes in which the section at a point is turned inside out: (t + y a' + z b')·(a×b)
/// is not positive.
struct Orientation {
  Lanes t, a, b;
};
TANDEM_INLINE void orient(const SectionState& section, Orientation& n) {
  const Lanes* a = section.u[1];
  const Lanes* b = section.u[2];
  const Lanes normal[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                           a[0] * b[1] - a[1] * b[0]};
  dot(section.u[0], normal, n.t);
  dot(section.u[3], normal, n.a);
  dot(section.u[4], normal, n.b);
}
TANDEM_INLINE int turned(const Orientation& n, double y, double z) {
  int bits = 0;
  const Lanes volume = n.t + y * n.a + z * n.b;
  for (int lane = 0; lane < kLanes; ++lane) bits |= (volume[lane] > 0.0 ? 0 : 1) << lane;
  return bits;
}

}  // namespace tandem::fem::ancf
