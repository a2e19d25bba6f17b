#include "fem_process/ancf/assumed_kernel.h"

#include <algorithm>

#include "fem_process/ancf/section_measures.h"
#include "fem_process/kernels/simd.h"

namespace tandem::fem::ancf {
namespace {

using Rules = std::vector<BeamKernel::Rule>;
using Batches = std::vector<BeamKernel::Batch>;

/// Section vectors, rates and c at a station.
TANDEM_INLINE void section_at(const Spread& spread, double xi, const Lanes& length, const Lanes* e,
                              const Lanes* e_rate, SectionState& section) {
  section_vectors(spread, e, section.u);
  section_vectors(spread, e_rate, section.rate);
  section.sag = xi * (1.0 - xi) * length * length;
  section.sags = xi * (1.0 - xi) > 0.0;
}

/// All points of a section. Returns the bits of the lanes that are turned inside out.
template <bool kTangent>
TANDEM_INLINE int sum_points(const BeamKernel::Rule& rule, const Lanes& length_weight,
                             const Measures& measures, const Orientation& orientation,
                             const BeamKernel::Reference* reference, MeasureSums& sums) {
  int inverted = 0;
  const bool viscous = rule.law.viscous();
  MetricPoint point;
  MetricStress stress;
  for (const BeamKernel::Point& at : rule.points) {
    double weight[kMeasures];
    measure_weights(at.y, at.z, weight);
    metric_at(measures.value, weight, point.C);
    metric_at(measures.rate, weight, point.rate);
    Lanes volume = length_weight * at.weight;
    LaneSix M;
    if (reference != nullptr) {
      turning(reference->inverse, M);
      turn(M, point.C);
      turn(M, point.rate);
      volume *= reference->determinant;
      ++reference;
    }
    inverted |= invert(point) | turned(orientation, at.y, at.z);
    metric_stress<kTangent>(rule.law, point, stress);
    if (reference != nullptr) {
      turn_back(M, stress.sigma);
      if constexpr (kTangent) {
        turn_back(M, stress.by_C);
        if (viscous) turn_back(M, stress.by_rate);
      }
    }
    add_point<kTangent>(volume, weight, viscous, stress, sums);
  }
  return inverted;
}

template <bool kTangent>
TANDEM_INLINE int evaluate_batch(const Rules& rules, const BeamKernel::Batch& batch, const Lanes* e,
                                 const Lanes* e_rate, double theta, Lanes* f, Lanes* K) {
  std::fill_n(f, kCoordinates, Lanes{});
  if constexpr (kTangent) std::fill_n(K, kCoordinates * kCoordinates, Lanes{});
  const BeamKernel::Reference* reference =
      batch.reference.empty() ? nullptr : batch.reference.data();
  int inverted = 0;
  MeasureSums sums;
  for (const BeamKernel::Station& station : rules.front().stations) {
    Spread spread;
    spread_at(station.xi, batch.length, spread);
    SectionState section;
    section_at(spread, station.xi, batch.length, e, e_rate, section);
    Measures measures;
    measure(section, measures);
    Orientation orientation;
    orient(section, orientation);
    bool viscous = false;
    std::fill_n(sums.force, kMeasures, Lanes{});
    if constexpr (kTangent) {
      std::fill_n(sums.by_value[0], kMeasures * kMeasures, Lanes{});
      std::fill_n(sums.by_rate[0], kMeasures * kMeasures, Lanes{});
    }
    for (const BeamKernel::Rule& rule : rules) {
      inverted |= sum_points<kTangent>(rule, station.weight * batch.length, measures, orientation,
                                       reference, sums);
      if (reference != nullptr) reference += rule.points.size();
      viscous = viscous || rule.law.viscous();
    }
    Resultants resultants{};
    to_vectors<kTangent>(section, theta, viscous, sums, resultants);
    spread_force(spread, resultants, f);
    if constexpr (kTangent) spread_tangent(spread, resultants, K);
  }
  return inverted & ((1 << batch.count) - 1);
}

template <bool kTangent>
TANDEM_INLINE void evaluate_all(const Rules& rules, const Batches& batches,
                                const LaneCoordinates* e, const LaneCoordinates* e_rate,
                                double theta, double* force, double* tangent, int& inverted) {
  Lanes f[kCoordinates];
  Lanes K[kTangent ? kCoordinates * kCoordinates : 1];
  inverted = 0;
  for (const BeamKernel::Batch& batch : batches) {
    for (int bits = evaluate_batch<kTangent>(rules, batch, e->at, e_rate->at, theta, f, K);
         bits != 0; bits &= bits - 1) {
      ++inverted;
    }
    store(f, kCoordinates, batch.count, force + batch.first * kCoordinates);
    if constexpr (kTangent) {
      store(K, kCoordinates * kCoordinates, batch.count,
            tangent + static_cast<std::ptrdiff_t>(batch.first) * kCoordinates * kCoordinates);
    }
    ++e;
    ++e_rate;
  }
}

TANDEM_INLINE void energy_of_all(const Rules& rules, const Batches& batches,
                                 const LaneCoordinates* e, double& energy) {
  for (const BeamKernel::Batch& batch : batches) {
    const BeamKernel::Reference* reference =
        batch.reference.empty() ? nullptr : batch.reference.data();
    Lanes sum{};
    for (const BeamKernel::Station& station : rules.front().stations) {
      Spread spread;
      spread_at(station.xi, batch.length, spread);
      SectionState section;
      section_at(spread, station.xi, batch.length, e->at, e->at, section);
      Measures measures;
      measure(section, measures);
      for (const BeamKernel::Rule& rule : rules) {
        for (const BeamKernel::Point& at : rule.points) {
          double weight[kMeasures];
          measure_weights(at.y, at.z, weight);
          LaneSymmetric C;
          metric_at(measures.value, weight, C);
          Lanes volume = station.weight * at.weight * batch.length;
          if (reference != nullptr) {
            LaneSix M;
            turning(reference->inverse, M);
            turn(M, C);
            volume *= reference->determinant;
            ++reference;
          }
          LaneSymmetric components;
          green_strain(C, components);
          LaneMatrix E;
          expand(components, E);
          Lanes density;
          energy_density(rule.law, E, density);
          sum += volume * density;
        }
      }
    }
    for (int n = 0; n < batch.count; ++n) energy += sum[n];
    ++e;
  }
}

TANDEM_VECTOR_FUNCTION(evaluate_forces, evaluate_all<false>,
                       (const Rules& rules, const Batches& batches, const LaneCoordinates* e,
                        const LaneCoordinates* e_rate, double theta, double* force, double* tangent,
                        int& inverted),
                       (rules, batches, e, e_rate, theta, force, tangent, inverted))
TANDEM_VECTOR_FUNCTION(evaluate_tangents, evaluate_all<true>,
                       (const Rules& rules, const Batches& batches, const LaneCoordinates* e,
                        const LaneCoordinates* e_rate, double theta, double* force, double* tangent,
                        int& inverted),
                       (rules, batches, e, e_rate, theta, force, tangent, inverted))
TANDEM_VECTOR_FUNCTION(evaluate_energy, energy_of_all,
                       (const Rules& rules, const Batches& batches, const LaneCoordinates* e,
                        double& energy),
                       (rules, batches, e, energy))

}  // namespace

void assumed_forces(const Rules& rules, const Batches& batches, const LaneCoordinates* e,
                    const LaneCoordinates* e_rate, double* force, int& inverted) {
  evaluate_forces(rules, batches, e, e_rate, 0.0, force, nullptr, inverted);
}

void assumed_tangents(const Rules& rules, const Batches& batches, const LaneCoordinates* e,
                      const LaneCoordinates* e_rate, double theta, double* force, double* tangent,
                      int& inverted) {
  evaluate_tangents(rules, batches, e, e_rate, theta, force, tangent, inverted);
}

void assumed_energy(const Rules& rules, const Batches& batches, const LaneCoordinates* e,
                    double& energy) {
  evaluate_energy(rules, batches, e, energy);
}

}  // namespace tandem::fem::ancf
