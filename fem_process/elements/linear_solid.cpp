#include "fem_process/elements/linear_solid.h"

#include "fem_process/material/stress_law.h"

namespace tandem::fem {
namespace {

/// C : sym(·) with columns as in SolidElement::Tangent.
Eigen::Matrix<double, 9, 9> small_strain_tangent(const Matrix6d& C) {
  Eigen::Matrix<double, 9, 9> A;
  for (int k = 0; k < 9; ++k) {
    Eigen::Matrix3d unit = Eigen::Matrix3d::Zero();
    unit(k % 3, k / 3) = 1.0;
    const Eigen::Matrix3d sigma = contract(C, unit);
    A.col(k) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(sigma.data());
  }
  return A;
}

}  // namespace

template <int N>
LinearSolid<N>::LinearSolid(const TetMesh& mesh, const Materials& materials)
    : X_(3 * mesh.nodes()),
      pattern_(pattern_of(mesh)),
      materials_(materials),
      elements_(make_elements<N>(mesh, pattern_)) {
  std::vector<typename Element::Tangent> tangents;
  for (const Material& material : materials.list) {
    check(material);
    C_.push_back(elasticity(material));
    tangents.push_back(small_strain_tangent(C_.back()));
  }
  for (int i = 0; i < mesh.nodes(); ++i) X_.segment<3>(3 * i) = mesh.X[static_cast<std::size_t>(i)];
  K_.assign(9 * pattern_.blocks(), 0.0);
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    typename Element::Stiffness K_e = Element::Stiffness::Zero();
    for (const typename Element::Point& at : elements_[e].points) {
      Element::add_stiffness(at, tangents[materials_.index(e)], K_e);
    }
    elements_[e].add_to_pattern(K_e, K_);
  }
}

template <int N>
int LinearSolid<N>::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int,
                             BlockValues& K) const {
  f_int = multiply(pattern_, K_, x - X_);
  K = K_;
  return 0;
}

template <int N>
Eigen::VectorXd LinearSolid<N>::derivative(const Eigen::VectorXd& /*x*/,
                                           const Eigen::VectorXd& /*y*/,
                                           const Eigen::VectorXd& dx) const {
  return multiply(pattern_, K_, dx);
}

template <int N>
double LinearSolid<N>::energy(const Eigen::VectorXd& x) const {
  const Eigen::VectorXd u = x - X_;
  return 0.5 * u.dot(multiply(pattern_, K_, u));
}

/// Mean von Mises stress over the volume.
template <int N>
std::vector<ElementResult> LinearSolid<N>::element_results(const Eigen::VectorXd& x) const {
  const Eigen::VectorXd u = x - X_;
  std::vector<ElementResult> results;
  results.reserve(elements_.size());
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const typename Element::Differences d = elements_[e].differences(u);
    double stress = 0.0;
    double volume = 0.0;
    for (const typename Element::Point& at : elements_[e].points) {
      const Eigen::Matrix3d gradient = Element::gradient_of(d, at);
      stress += at.volume * von_mises(contract(C_[materials_.index(e)], gradient));
      volume += at.volume;
    }
    results.push_back({stress / volume, 0.0});
  }
  return results;
}

template class LinearSolid<4>;
template class LinearSolid<10>;

}  // namespace tandem::fem
