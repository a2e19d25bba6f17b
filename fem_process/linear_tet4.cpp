#include "fem_process/linear_tet4.h"

#include "fem_process/stress_law.h"

namespace tandem::fem {

LinearTet4::LinearTet4(const TetMesh& mesh, const Material& material)
    : X_(3 * mesh.nodes()), D_(elasticity(material)), pattern_(pattern_of(mesh)) {
  check(material);
  for (int i = 0; i < mesh.nodes(); ++i) X_.segment<3>(3 * i) = mesh.X[static_cast<std::size_t>(i)];
  K_.assign(9 * pattern_.blocks(), 0.0);
  shapes_.reserve(mesh.tets.size());
  for (const Tet& tet : mesh.tets) {
    const TetShape& shape = shapes_.emplace_back(make_tet_shape(mesh, tet, pattern_));
    const Eigen::Matrix<double, 6, 12> B = strain_matrix(shape.gradients);
    const Matrix12d K = shape.volume * B.transpose() * D_ * B;
    // Symmetric but for round-off: made so exactly, the solvers take one triangle.
    add_element_matrix(shape, 0.5 * (K + K.transpose()), K_);
  }
}

int LinearTet4::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int, BlockValues& K) const {
  f_int = multiply(pattern_, K_, x - X_);
  K = K_;
  return 0;
}

Eigen::VectorXd LinearTet4::derivative(const Eigen::VectorXd& /*x*/, const Eigen::VectorXd& /*y*/,
                                       const Eigen::VectorXd& dx) const {
  return multiply(pattern_, K_, dx);
}

double LinearTet4::energy(const Eigen::VectorXd& x) const {
  const Eigen::VectorXd u = x - X_;
  return 0.5 * u.dot(multiply(pattern_, K_, u));
}

std::vector<ElementResult> LinearTet4::element_results(const Eigen::VectorXd& x) const {
  const Eigen::VectorXd u = x - X_;
  std::vector<ElementResult> results;
  results.reserve(shapes_.size());
  for (const TetShape& shape : shapes_) {
    Vector12d u_e;
    for (int i = 0; i < 4; ++i) {
      u_e.segment<3>(3 * i) = u.segment<3>(3 * shape.nodes[static_cast<std::size_t>(i)]);
    }
    const Eigen::Matrix<double, 6, 1> s = D_ * (strain_matrix(shape.gradients) * u_e);
    Eigen::Matrix3d sigma;
    sigma << s(0), s(3), s(5), s(3), s(1), s(4), s(5), s(4), s(2);
    results.push_back({von_mises(sigma), 0.0});
  }
  return results;
}

}  // namespace tandem::fem
