#include "fem_process/ancf/beam_mesh.h"

#include <Eigen/Geometry>
#include <cmath>

#include "protocol/contract/error.h"

namespace tandem::fem::ancf {
namespace {

/// Orthonormal A with the axis as its second column; the identity for (0, 1, 0).
Eigen::Matrix3d gradient_lines(const Eigen::Vector3d& axis) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Identity();
  if (axis == Eigen::Vector3d::UnitY()) return A;
  require(std::abs(axis.norm() - 1.0) < 1e-9, "fem: the axis of a pin must have unit length.");
  // The parameter line that is least along the axis gives the first column.
  Eigen::Index least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d a1 = Eigen::Vector3d::Unit(least).cross(axis).normalized();
  A << a1, axis, a1.cross(axis);
  return A;
}

/// The unknown vectors at one end of an element: r, r_u, r_v, r_w.
using EndVectors = std::array<int, 4>;

class Joiner {
 public:
  explicit Joiner(const Chain& chain) : chain_(chain), A_(gradient_lines(chain.pin_axis)) {}

  BeamMesh run() {
    const auto n = chain_.lengths_m.size();
    require(n > 0 && chain_.ends.size() == 2 * n, "fem: a chain needs two end frames per element.");
    std::vector<EndVectors> at(2 * n);
    at[0] = fresh(0);
    for (std::size_t e = 0; e < n; ++e) {
      const bool closes = chain_.closed && e + 1 == n;
      // The end of the last element of a closed chain meets the beginning of the first.
      at[2 * e + 1] = closes ? joined(2 * e + 1, at[0]) : fresh(2 * e + 1);
      if (e + 1 < n) at[2 * e + 2] = joined(2 * e + 2, at[2 * e + 1]);
    }
    for (std::size_t e = 0; e < n; ++e) {
      BeamElement element{.length_m = chain_.lengths_m[e]};
      add_terms(at[2 * e], 0, element);
      add_terms(at[2 * e + 1], 4, element);
      mesh_.elements.push_back(std::move(element));
      mesh_.end_position.insert(mesh_.end_position.end(), {at[2 * e][0], at[2 * e + 1][0]});
    }
    finish();
    return std::move(mesh_);
  }

 private:
  int add_vector(const Eigen::Vector3d& value) {
    values_.push_back(value);
    return static_cast<int>(values_.size()) - 1;
  }

  Eigen::Vector3d gradient(std::size_t end, int line) const {
    return chain_.ends[end].gradients * A_.col(line);
  }

  EndVectors fresh(std::size_t end) {
    return {add_vector(chain_.ends[end].r), add_vector(gradient(end, 0)),
            add_vector(gradient(end, 1)), add_vector(gradient(end, 2))};
  }

  EndVectors joined(std::size_t end, const EndVectors& other) {
    switch (chain_.joint) {
      case Joint::Rigid:
        return other;
      case Joint::Pin:
        return {other[0], add_vector(gradient(end, 0)), other[2], add_vector(gradient(end, 2))};
      case Joint::Ball:
        return {other[0], add_vector(gradient(end, 0)), add_vector(gradient(end, 1)),
                add_vector(gradient(end, 2))};
    }
    return other;
  }

  /// [r_x r_y r_z] = [r_u r_v r_w] Aᵀ.
  void add_terms(const EndVectors& end, int first_slot, BeamElement& element) const {
    element.terms.push_back({first_slot, end[0], 1.0});
    for (int line = 0; line < 3; ++line) {
      for (int k = 0; k < 3; ++k) {
        if (A_(line, k) == 0.0) continue;
        element.terms.push_back(
            {first_slot + 1 + line, end[static_cast<std::size_t>(k + 1)], A_(line, k)});
      }
    }
  }

  void finish() {
    mesh_.vectors = static_cast<int>(values_.size());
    mesh_.q0.resize(mesh_.unknowns());
    for (std::size_t v = 0; v < values_.size(); ++v) {
      mesh_.q0.segment<3>(3 * static_cast<Eigen::Index>(v)) = values_[v];
    }
    mesh_.fixed.assign(values_.size(), false);
    if (!chain_.curved_reference) return;
    for (int e = 0; e < static_cast<int>(mesh_.elements.size()); ++e) {
      mesh_.reference.push_back(mesh_.gather(e, mesh_.q0));
    }
  }

  const Chain& chain_;
  Eigen::Matrix3d A_;
  BeamMesh mesh_;
  std::vector<Eigen::Vector3d> values_;
};

}  // namespace

BeamVectors BeamMesh::gather(int element, const Eigen::VectorXd& q) const {
  BeamVectors e = BeamVectors::Zero();
  for (const Term& term : elements[static_cast<std::size_t>(element)].terms) {
    e.col(term.slot) += term.factor * q.segment<3>(3 * term.vector);
  }
  return e;
}

BeamMesh join(const Chain& chain) { return Joiner(chain).run(); }

void support(BeamMesh& mesh, bool at_end, Support kind) {
  if (kind == Support::Free) return;
  const BeamElement& element = at_end ? mesh.elements.back() : mesh.elements.front();
  const int first_slot = at_end ? 4 : 0;
  for (const Term& term : element.terms) {
    const bool here = term.slot >= first_slot && term.slot < first_slot + 4;
    if (here && (kind == Support::Clamped || term.slot == first_slot)) {
      mesh.fixed[static_cast<std::size_t>(term.vector)] = true;
    }
  }
}

}  // namespace tandem::fem::ancf
