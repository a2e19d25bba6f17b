#include "fem_process/hyperelastic_tet4.h"

#include <Eigen/Dense>
#include <cmath>

#include "fem_process/polar.h"

namespace tandem::fem {
namespace {

/// Σ x_i ∂N_i/∂X, from differences to corner 0.
Eigen::Matrix3d gradient_of(const TetShape& shape, const Eigen::VectorXd& x) {
  return edges_of(shape.nodes, x) * shape.gradients.bottomRows<3>();
}

void add_forces(const TetShape& shape, const Eigen::Matrix3d& P, Eigen::VectorXd& f) {
  for (int i = 0; i < 4; ++i) {
    f.segment<3>(3 * shape.nodes[static_cast<std::size_t>(i)]) +=
        shape.volume * (P * shape.gradients.row(i).transpose());
  }
}

}  // namespace

template <class Law>
HyperelasticTet4<Law>::HyperelasticTet4(const TetMesh& mesh, const Material& material)
    : pattern_(pattern_of(mesh)), law_(elasticity(material)) {
  check(material);
  shapes_.reserve(mesh.tets.size());
  for (const Tet& tet : mesh.tets) shapes_.push_back(make_tet_shape(mesh, tet, pattern_));
}

/// Columns of corners 1..3 by differentiation; corner 0 takes minus their sum, since f does not
/// change with a common translation.
template <class Law>
Matrix12d HyperelasticTet4<Law>::stiffness(const TetShape& shape,
                                           const typename Law::Point& point) const {
  const Eigen::Matrix3d g = shape.gradients.bottomRows<3>().transpose();  // column i: ∂N_i/∂X
  Eigen::Matrix<double, 9, 9> inner;
  for (int j = 0; j < 3; ++j) {
    for (int a = 0; a < 3; ++a) {
      const Eigen::Matrix3d A = Eigen::Vector3d::Unit(a) * g.col(j).transpose();
      const Eigen::Matrix3d forces = shape.volume * law_.derivative(point, A) * g;
      inner.col(3 * j + a) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(forces.data());
    }
  }
  // Symmetric but for round-off: made so exactly, the solvers take one triangle.
  const Eigen::Matrix<double, 9, 9> symmetric = 0.5 * (inner + inner.transpose());
  Eigen::Matrix<double, 9, 3> to_corner_0 = Eigen::Matrix<double, 9, 3>::Zero();
  for (int i = 0; i < 3; ++i) to_corner_0 -= symmetric.middleCols<3>(3 * i);
  Eigen::Matrix3d at_corner_0 = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) at_corner_0 -= to_corner_0.middleRows<3>(3 * i);
  Matrix12d K;
  K.bottomRightCorner<9, 9>() = symmetric;
  K.bottomLeftCorner<9, 3>() = to_corner_0;
  K.topRightCorner<3, 9>() = to_corner_0.transpose();
  K.topLeftCorner<3, 3>() = 0.5 * (at_corner_0 + at_corner_0.transpose());
  return K;
}

template <class Law>
int HyperelasticTet4<Law>::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int,
                                    BlockValues& K) const {
  f_int.setZero(x.size());
  K.assign(9 * pattern_.blocks(), 0.0);
  int inverted = 0;
  for (const TetShape& shape : shapes_) {
    const typename Law::Point point = law_.at(gradient_of(shape, x));
    inverted += point.inverted ? 1 : 0;
    add_forces(shape, law_.stress(point), f_int);
    add_element_matrix(shape, stiffness(shape, point), K);
  }
  return inverted;
}

template <class Law>
Eigen::VectorXd HyperelasticTet4<Law>::derivative(const Eigen::VectorXd& x,
                                                  const Eigen::VectorXd& y,
                                                  const Eigen::VectorXd& dx) const {
  Eigen::VectorXd change = Eigen::VectorXd::Zero(x.size());
  for (const TetShape& shape : shapes_) {
    const typename Law::Point point = law_.at(gradient_of(shape, x));
    const Eigen::Matrix3d dF = gradient_of(shape, dx);
    const Eigen::Matrix3d Y = gradient_of(shape, y);
    add_forces(shape, law_.derivative(point, dF) + law_.second_derivative(point, Y, dF), change);
  }
  return change;
}

template <class Law>
double HyperelasticTet4<Law>::energy(const Eigen::VectorXd& x) const {
  double sum = 0.0;
  for (const TetShape& shape : shapes_) {
    sum += shape.volume * law_.energy_density(law_.at(gradient_of(shape, x)));
  }
  return sum;
}

template <class Law>
std::vector<ElementResult> HyperelasticTet4<Law>::element_results(const Eigen::VectorXd& x) const {
  std::vector<ElementResult> results;
  results.reserve(shapes_.size());
  for (const TetShape& shape : shapes_) {
    const Eigen::Matrix3d F = gradient_of(shape, x);
    const double angle = Eigen::AngleAxisd(polar_rotation(F).R).angle();
    results.push_back({von_mises(law_.output_stress(law_.at(F))), angle});
  }
  return results;
}

template class HyperelasticTet4<CorotatedLaw>;
template class HyperelasticTet4<StVenantKirchhoffLaw>;

}  // namespace tandem::fem
