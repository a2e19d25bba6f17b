#include "fem_process/elements/hyperelastic.h"

#include <Eigen/Dense>

#include "fem_process/kernels/polar.h"

namespace tandem::fem {

template <class Law, class Tangent, int N>
Hyperelastic<Law, Tangent, N>::Hyperelastic(const TetMesh& mesh, const Materials& materials)
    : pattern_(pattern_of(mesh)),
      materials_(materials),
      elements_(make_elements<N>(mesh, pattern_)) {
  for (const Material& material : materials.list) {
    check(material);
    laws_.emplace_back(elasticity(material));
  }
}

template <class Law, class Tangent, int N>
auto Hyperelastic<Law, Tangent, N>::tangent(const Law& law, const typename Law::Point& point) ->
    typename Element::Tangent {
  typename Element::Tangent A;
  for (int b = 0; b < 3; ++b) {
    for (int a = 0; a < 3; ++a) {
      Eigen::Matrix3d unit = Eigen::Matrix3d::Zero();
      unit(a, b) = 1.0;
      const Eigen::Matrix3d dP = Tangent::value(law, point, unit);
      A.col(3 * b + a) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(dP.data());
    }
  }
  return A;
}

template <class Law, class Tangent, int N>
int Hyperelastic<Law, Tangent, N>::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int,
                                            BlockValues& K) const {
  f_int.setZero(x.size());
  K.assign(9 * pattern_.blocks(), 0.0);
  int inverted = 0;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    const typename Element::Differences d = element.differences(x);
    typename Element::Stiffness K_e = Element::Stiffness::Zero();
    bool folded = false;
    for (const typename Element::Point& at : element.points) {
      const typename Law::Point point = law(e).at(Element::gradient_of(d, at));
      folded = folded || point.inverted;
      element.add_forces(at, law(e).stress(point), f_int);
      Element::add_stiffness(at, tangent(law(e), point), K_e);
    }
    element.add_to_pattern(K_e, K);
    inverted += folded ? 1 : 0;
  }
  return inverted;
}

template <class Law, class Tangent, int N>
Eigen::VectorXd Hyperelastic<Law, Tangent, N>::derivative(const Eigen::VectorXd& x,
                                                          const Eigen::VectorXd& y,
                                                          const Eigen::VectorXd& dx) const {
  Eigen::VectorXd change = Eigen::VectorXd::Zero(x.size());
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    const typename Element::Differences d = element.differences(x);
    const typename Element::Differences d_y = element.differences(y);
    const typename Element::Differences d_dx = element.differences(dx);
    for (const typename Element::Point& at : element.points) {
      const typename Law::Point point = law(e).at(Element::gradient_of(d, at));
      const Eigen::Matrix3d dF = Element::gradient_of(d_dx, at);
      const Eigen::Matrix3d Y = Element::gradient_of(d_y, at);
      element.add_forces(
          at, law(e).derivative(point, dF) + Tangent::derivative(law(e), point, Y, dF), change);
    }
  }
  return change;
}

template <class Law, class Tangent, int N>
double Hyperelastic<Law, Tangent, N>::energy(const Eigen::VectorXd& x) const {
  double sum = 0.0;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const typename Element::Differences d = elements_[e].differences(x);
    for (const typename Element::Point& at : elements_[e].points) {
      sum += at.volume * law(e).energy_density(law(e).at(Element::gradient_of(d, at)));
    }
  }
  return sum;
}

/// Means over the volume: of the von Mises stress, and of F, whose rotation is the element's.
template <class Law, class Tangent, int N>
std::vector<ElementResult> Hyperelastic<Law, Tangent, N>::element_results(
    const Eigen::VectorXd& x) const {
  std::vector<ElementResult> results;
  results.reserve(elements_.size());
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const typename Element::Differences d = elements_[e].differences(x);
    Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
    double stress = 0.0;
    double volume = 0.0;
    for (const typename Element::Point& at : elements_[e].points) {
      const Eigen::Matrix3d F = Element::gradient_of(d, at);
      mean += at.volume * F;
      stress += at.volume * von_mises(law(e).output_stress(law(e).at(F)));
      volume += at.volume;
    }
    const double angle = Eigen::AngleAxisd(polar_rotation(mean / volume).R).angle();
    results.push_back({stress / volume, angle});
  }
  return results;
}

template class Hyperelastic<CorotatedLaw, SimplifiedTangent, 4>;
template class Hyperelastic<CorotatedLaw, SimplifiedTangent, 10>;
template class Hyperelastic<CorotatedLaw, ExactTangent, 4>;
template class Hyperelastic<CorotatedLaw, ExactTangent, 10>;
template class Hyperelastic<StVenantKirchhoffLaw, ExactTangent, 4>;
template class Hyperelastic<StVenantKirchhoffLaw, ExactTangent, 10>;

}  // namespace tandem::fem
