#include "fem_process/ancf/beam_kernel.h"

#include <Eigen/LU>
#include <algorithm>

#include "fem_process/ancf/assumed_kernel.h"
#include "fem_process/ancf/point_stress.h"
#include "fem_process/ancf/section_vectors.h"
#include "fem_process/kernels/simd.h"

namespace tandem::fem::ancf {
namespace {

/// [t + y a' + z b' | a | b].
TANDEM_INLINE void gradient_at(const Lanes (&u)[kSection][3], double y, double z, LaneMatrix& F) {
  for (int i = 0; i < 3; ++i) {
    F.at[3 * i] = u[0][i] + y * u[3][i] + z * u[4][i];
    F.at[3 * i + 1] = u[1][i];
    F.at[3 * i + 2] = u[2][i];
  }
}

/// T with both of its material axes turned by J₀⁻¹: J₀⁻¹_JM T_iMkN J₀⁻¹_LN.
TANDEM_INLINE void pull_back(const LaneMatrix& inverse, LaneTangent& T) {
  LaneTangent half;
  for (int J = 0; J < 3; ++J) {
    for (int N = 0; N < 3; ++N) {
      for (int n = 0; n < 9; ++n) {
        half.at[J][N][n] = inverse.at[3 * J] * T.at[0][N][n] +
                           inverse.at[3 * J + 1] * T.at[1][N][n] +
                           inverse.at[3 * J + 2] * T.at[2][N][n];
      }
    }
  }
  for (int J = 0; J < 3; ++J) {
    for (int L = 0; L < 3; ++L) {
      for (int n = 0; n < 9; ++n) {
        T.at[J][L][n] = inverse.at[3 * L] * half.at[J][0][n] +
                        inverse.at[3 * L + 1] * half.at[J][1][n] +
                        inverse.at[3 * L + 2] * half.at[J][2][n];
      }
    }
  }
}

template <bool kTangent>
TANDEM_INLINE void add_point(const Lanes& weight, double y, double z, const LaneMatrix& P,
                             const LaneTangent& T, Resultants& sum) {
  const double arm[kSection] = {1.0, 1.0, 1.0, y, z};
  constexpr int kColumn[kSection] = {0, 1, 2, 0, 0};
  for (int s = 0; s < kSection; ++s) {
    const Lanes w = weight * arm[s];
    for (int i = 0; i < 3; ++i) sum.force[s][i] += w * P.at[3 * i + kColumn[s]];
    if constexpr (!kTangent) continue;
    for (int t = 0; t < kSection; ++t) {
      const Lanes both = w * arm[t];
      for (int n = 0; n < 9; ++n) {
        sum.tangent[s][t][n] += both * T.at[kColumn[s]][kColumn[t]][n];
      }
    }
  }
}

/// All points of a section. Returns the bits of the lanes that are turned inside out.
template <bool kTangent>
TANDEM_INLINE int sum_section(const BeamKernel::Rule& rule, const Lanes& length_weight,
                              double theta, const Lanes (&u)[kSection][3],
                              const Lanes (&rate)[kSection][3],
                              const BeamKernel::Reference* reference, Resultants& sum) {
  int inverted = 0;
  LanePoint point;
  LaneMatrix P;
  LaneTangent T;
  for (const BeamKernel::Point& at : rule.points) {
    gradient_at(u, at.y, at.z, point.F);
    gradient_at(rate, at.y, at.z, point.rate);
    Lanes weight = length_weight * at.weight;
    if (reference != nullptr) {
      LaneMatrix turned;
      times(point.F, reference->inverse, turned);
      point.F = turned;
      times(point.rate, reference->inverse, turned);
      point.rate = turned;
      weight *= reference->determinant;
    }
    inverted |= invert(point);
    point_stress<kTangent>(rule.law, theta, point, P, T);
    if (reference != nullptr) {
      LaneMatrix turned;
      times_transposed(P, reference->inverse, turned);
      P = turned;
      if constexpr (kTangent) pull_back(reference->inverse, T);
      ++reference;
    }
    add_point<kTangent>(weight, at.y, at.z, P, T, sum);
  }
  return inverted;
}

template <bool kTangent>
TANDEM_INLINE int evaluate_batch(const std::vector<BeamKernel::Rule>& rules,
                                 const BeamKernel::Batch& batch, const Lanes* e,
                                 const Lanes* e_rate, double theta, Lanes* f, Lanes* K) {
  std::fill_n(f, kCoordinates, Lanes{});
  if constexpr (kTangent) std::fill_n(K, kCoordinates * kCoordinates, Lanes{});
  const BeamKernel::Reference* reference =
      batch.reference.empty() ? nullptr : batch.reference.data();
  int inverted = 0;
  for (const BeamKernel::Rule& rule : rules) {
    for (const BeamKernel::Station& station : rule.stations) {
      Spread spread;
      spread_at(station.xi, batch.length, spread);
      Lanes u[kSection][3];
      Lanes rate[kSection][3];
      section_vectors(spread, e, u);
      section_vectors(spread, e_rate, rate);
      Resultants sum{};
      inverted |= sum_section<kTangent>(rule, station.weight * batch.length, theta, u, rate,
                                        reference, sum);
      if (reference != nullptr) reference += rule.points.size();
      spread_force(spread, sum, f);
      if constexpr (kTangent) spread_tangent(spread, sum, K);
    }
  }
  return inverted & ((1 << batch.count) - 1);
}

template <bool kTangent>
TANDEM_INLINE void evaluate_all(const std::vector<BeamKernel::Rule>& rules,
                                const std::vector<BeamKernel::Batch>& batches,
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

TANDEM_INLINE void energy_of_all(const std::vector<BeamKernel::Rule>& rules,
                                 const std::vector<BeamKernel::Batch>& batches,
                                 const LaneCoordinates* e, double& energy) {
  for (const BeamKernel::Batch& batch : batches) {
    const BeamKernel::Reference* reference =
        batch.reference.empty() ? nullptr : batch.reference.data();
    Lanes sum{};
    for (const BeamKernel::Rule& rule : rules) {
      for (const BeamKernel::Station& station : rule.stations) {
        Spread spread;
        spread_at(station.xi, batch.length, spread);
        Lanes u[kSection][3];
        section_vectors(spread, e->at, u);
        for (const BeamKernel::Point& at : rule.points) {
          LanePoint point;
          gradient_at(u, at.y, at.z, point.F);
          Lanes weight = station.weight * at.weight * batch.length;
          if (reference != nullptr) {
            LaneMatrix turned;
            times(point.F, reference->inverse, turned);
            point.F = turned;
            weight *= reference->determinant;
            ++reference;
          }
          LaneMatrix E;
          green_strain(point.F, E);
          Lanes density;
          energy_density(rule.law, E, density);
          sum += weight * density;
        }
      }
    }
    for (int n = 0; n < batch.count; ++n) energy += sum[n];
    ++e;
  }
}

TANDEM_VECTOR_FUNCTION(evaluate_forces, evaluate_all<false>,
                       (const std::vector<BeamKernel::Rule>& rules,
                        const std::vector<BeamKernel::Batch>& batches, const LaneCoordinates* e,
                        const LaneCoordinates* e_rate, double theta, double* force, double* tangent,
                        int& inverted),
                       (rules, batches, e, e_rate, theta, force, tangent, inverted))
TANDEM_VECTOR_FUNCTION(evaluate_tangents, evaluate_all<true>,
                       (const std::vector<BeamKernel::Rule>& rules,
                        const std::vector<BeamKernel::Batch>& batches, const LaneCoordinates* e,
                        const LaneCoordinates* e_rate, double theta, double* force, double* tangent,
                        int& inverted),
                       (rules, batches, e, e_rate, theta, force, tangent, inverted))
TANDEM_VECTOR_FUNCTION(evaluate_energy, energy_of_all,
                       (const std::vector<BeamKernel::Rule>& rules,
                        const std::vector<BeamKernel::Batch>& batches, const LaneCoordinates* e,
                        double& energy),
                       (rules, batches, e, energy))

BeamKernel::Rule make_rule(const PointLaw& law, const GaussRule& x, int along_y, int along_z,
                           const BeamSection& section) {
  BeamKernel::Rule rule{.law = law};
  const GaussRule y = gauss_rule(along_y);
  const GaussRule z = gauss_rule(along_z);
  for (std::size_t i = 0; i < x.point.size(); ++i) {
    rule.stations.push_back({x.point[i], x.weight[i]});
  }
  for (std::size_t j = 0; j < y.point.size(); ++j) {
    for (std::size_t k = 0; k < z.point.size(); ++k) {
      rule.points.push_back({section.width_m * (y.point[j] - 0.5),
                             section.height_m * (z.point[k] - 0.5),
                             section.area_m2() * y.weight[j] * z.weight[k]});
    }
  }
  return rule;
}

/// The three points of Lobatto's rule on [0, 1].
GaussRule lobatto_rule() {
  return {.point = {0.0, 0.5, 1.0}, .weight = {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0}};
}

}  // namespace

BeamKernel::BeamKernel(const BeamMesh& mesh, const BeamSection& section, const RuleLaws& laws,
                       const GaussOrder& order, Strain strain)
    : strain_(strain) {
  const GaussRule along = strain == Strain::Assumed ? lobatto_rule() : gauss_rule(order.x);
  rules_.push_back(make_rule(laws.volume, along, order.y, order.z, section));
  if (laws.uses_axis) rules_.push_back(make_rule(laws.axis, along, 1, 1, section));
  const int n = static_cast<int>(mesh.elements.size());
  for (int first = 0; first < n; first += kLanes) {
    Batch batch{.first = first, .count = std::min(kLanes, n - first)};
    for (int lane = 0; lane < kLanes; ++lane) {
      // Idle lanes repeat the last element.
      const auto& element = mesh.elements[static_cast<std::size_t>(std::min(first + lane, n - 1))];
      batch.length[lane] = element.length_m;
      for (const Term& term : element.terms) {
        terms_.push_back({(first / kLanes * kCoordinates + 3 * term.slot) * kLanes + lane,
                          term.vector, term.factor});
      }
    }
    if (!mesh.reference.empty()) batch.reference = references(mesh, batch);
    batches_.push_back(std::move(batch));
  }
}

std::vector<BeamKernel::Reference> BeamKernel::references(const BeamMesh& mesh,
                                                          const Batch& batch) const {
  std::vector<Reference> all;
  const int last = static_cast<int>(mesh.elements.size()) - 1;
  const auto add = [&](const Station& station, const Point& point) {
    Reference reference;
    for (int lane = 0; lane < kLanes; ++lane) {
      const auto& vectors =
          mesh.reference[static_cast<std::size_t>(std::min(batch.first + lane, last))];
      const StressFree at =
          strain_ == Strain::Assumed
              ? assumed_stress_free(vectors, batch.length[lane], station.xi, point.y, point.z)
              : stress_free(vectors, batch.length[lane], station.xi, point.y, point.z);
      for (int k = 0; k < 9; ++k) reference.inverse.at[k][lane] = at.inverse(k / 3, k % 3);
      reference.determinant[lane] = at.volume;
    }
    all.push_back(reference);
  };
  if (strain_ == Strain::Assumed) {
    for (std::size_t s = 0; s < rules_.front().stations.size(); ++s) {
      for (const Rule& rule : rules_) {
        for (const Point& point : rule.points) add(rule.stations[s], point);
      }
    }
    return all;
  }
  for (const Rule& rule : rules_) {
    for (const Station& station : rule.stations) {
      for (const Point& point : rule.points) add(station, point);
    }
  }
  return all;
}

void BeamKernel::gather(const Eigen::VectorXd& q, std::vector<LaneCoordinates>& lanes) const {
  lanes.assign(batches_.size(), LaneCoordinates{});
  auto* out = reinterpret_cast<double*>(lanes.data());
  for (const SlotTerm& term : terms_) {
    const double* from = q.data() + 3 * static_cast<std::ptrdiff_t>(term.vector);
    for (int c = 0; c < 3; ++c) out[term.target + c * kLanes] += term.factor * from[c];
  }
}

int BeamKernel::forces(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                       ElementArrays& out) const {
  static thread_local std::vector<LaneCoordinates> e;
  static thread_local std::vector<LaneCoordinates> e_rate;
  gather(q, e);
  gather(v, e_rate);
  int inverted = 0;
  if (strain_ == Strain::Assumed) {
    assumed_forces(rules_, batches_, e.data(), e_rate.data(), out.force.data(), inverted);
    return inverted;
  }
  evaluate_forces(rules_, batches_, e.data(), e_rate.data(), 0.0, out.force.data(), nullptr,
                  inverted);
  return inverted;
}

int BeamKernel::tangents(const Eigen::VectorXd& q, const Eigen::VectorXd& v, double theta,
                         ElementArrays& out) const {
  static thread_local std::vector<LaneCoordinates> e;
  static thread_local std::vector<LaneCoordinates> e_rate;
  gather(q, e);
  gather(v, e_rate);
  int inverted = 0;
  if (strain_ == Strain::Assumed) {
    assumed_tangents(rules_, batches_, e.data(), e_rate.data(), theta, out.force.data(),
                     out.tangent.data(), inverted);
    return inverted;
  }
  evaluate_tangents(rules_, batches_, e.data(), e_rate.data(), theta, out.force.data(),
                    out.tangent.data(), inverted);
  return inverted;
}

double BeamKernel::energy(const Eigen::VectorXd& q) const {
  std::vector<LaneCoordinates> e;
  gather(q, e);
  double energy = 0.0;
  if (strain_ == Strain::Assumed) {
    assumed_energy(rules_, batches_, e.data(), energy);
  } else {
    evaluate_energy(rules_, batches_, e.data(), energy);
  }
  return energy;
}

}  // namespace tandem::fem::ancf
