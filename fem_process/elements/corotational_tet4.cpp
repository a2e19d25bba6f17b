#include "fem_process/elements/corotational_tet4.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "fem_process/kernels/cross_matrix.h"
#include "fem_process/kernels/polar.h"

namespace tandem::fem {
namespace {

Tet4 make_element(const TetMesh& mesh, const Tet& tet, const Matrix6d& D,
                  const BlockPattern& pattern) {
  Tet4 element{make_tet_shape(mesh, tet, pattern), {}};
  const Eigen::Matrix<double, 6, 12> B = strain_matrix(element.gradients);
  const Matrix12d K = element.volume * B.transpose() * D * B;
  // The product is symmetric up to round-off only; the solvers take one triangle.
  element.K = 0.5 * (K + K.transpose());
  return element;
}

std::vector<TetShape> tet_shapes(const TetMesh& mesh, const BlockPattern& pattern) {
  std::vector<TetShape> shapes;
  shapes.reserve(mesh.tets.size());
  for (const Tet& tet : mesh.tets) shapes.push_back(make_tet_shape(mesh, tet, pattern));
  return shapes;
}

}  // namespace

CorotationalTet4::CorotationalTet4(const TetMesh& mesh, const Material& material, ThreadTeam* team)
    : X_(3 * mesh.nodes()),
      D_(elasticity(material)),
      pattern_(pattern_of(mesh)),
      kernel_(tet_shapes(mesh, pattern_), pattern_, material, mesh.X),
      team_(team) {
  check(material);
  for (int i = 0; i < mesh.nodes(); ++i) X_.segment<3>(3 * i) = mesh.X[static_cast<std::size_t>(i)];
  elements_.reserve(mesh.tets.size());
  for (const Tet& tet : mesh.tets) elements_.push_back(make_element(mesh, tet, D_, pattern_));
}

CorotationalTet4::Local CorotationalTet4::localise(const Tet4& element,
                                                   const Eigen::VectorXd& x) const {
  const Eigen::Matrix3d edges = edges_of(element.nodes, x);
  const Eigen::Matrix3d F = edges * element.gradients.bottomRows<3>();
  const PolarRotation polar = polar_rotation(F);
  Local local{polar.R, F, Vector12d::Zero(), polar.inverted};
  for (int k = 0; k < 3; ++k) {
    local.u.segment<3>(3 * k + 3) =
        polar.R.transpose() * edges.col(k) -
        (X_.segment<3>(3 * element.nodes[static_cast<std::size_t>(k) + 1]) -
         X_.segment<3>(3 * element.nodes[0]));
  }
  return local;
}

int CorotationalTet4::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int,
                               BlockValues& K) const {
  ThreadTeam alone;
  return kernel_.evaluate(x, f_int, K, team_ != nullptr ? *team_ : alone);
}

/// With dR = R Ω and S = Rᵀ F: from Rᵀ dF = Ω S + dS, the axial vector ω of Ω solves
///   (tr S I − S) ω = axial(Rᵀ dF − dFᵀ R),
/// and d(R K (Rᵀ (x + y) − X)) = R (Ω q + K (Rᵀ dx − Ω Rᵀ (x + y))), q = K (u + Rᵀ y).
Eigen::VectorXd CorotationalTet4::derivative(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                                             const Eigen::VectorXd& dx) const {
  Eigen::VectorXd change = Eigen::VectorXd::Zero(x.size());
  for (const Tet4& element : elements_) {
    const Local local = localise(element, x);
    const Eigen::Matrix3d Rt = local.R.transpose();
    Eigen::Matrix3d dF = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 4; ++i) {
      dF +=
          dx.segment<3>(3 * element.nodes[static_cast<std::size_t>(i)]) * element.gradients.row(i);
    }
    const Eigen::Matrix3d A = Rt * dF;
    const Eigen::Matrix3d S = Rt * local.F;
    const Eigen::Matrix3d T = S.trace() * Eigen::Matrix3d::Identity() - S;
    const Eigen::Vector3d omega =
        T.inverse() * Eigen::Vector3d(A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1));
    Vector12d whole;  // u + Rᵀ y
    Vector12d turned;
    for (int i = 0; i < 4; ++i) {
      const Eigen::Index node = 3 * element.nodes[static_cast<std::size_t>(i)];
      const Eigen::Vector3d y_local = Rt * y.segment<3>(node);
      const Eigen::Vector3d x_local =
          Rt * (x.segment<3>(node) - x.segment<3>(3 * element.nodes[0]));
      whole.segment<3>(3 * i) = local.u.segment<3>(3 * i) + y_local;
      turned.segment<3>(3 * i) = Rt * dx.segment<3>(node) - omega.cross(x_local + y_local);
    }
    const Vector12d q = element.K * whole;
    const Vector12d r = element.K * turned;
    for (int i = 0; i < 4; ++i) {
      change.segment<3>(3 * element.nodes[static_cast<std::size_t>(i)]) +=
          local.R * (omega.cross(q.segment<3>(3 * i)) + r.segment<3>(3 * i));
    }
  }
  return change;
}

/// The exact tangent is K_R and what the elements' turning adds: with a_i = Rᵀ dx_i,
/// ω = Σ W_i a_i, W_i = (tr S I − S)⁻¹ [g_i]×, g_i the gradient of N_i, and local positions x_j,
///   df_i = R (Σ_j K_ij a_j + (Σ_j K_ij [x_j]× − [q_i]×) ω).
Eigen::MatrixXd CorotationalTet4::derivatives(const Eigen::VectorXd& x,
                                              const Eigen::MatrixXd& dx) const {
  ThreadTeam alone;
  ThreadTeam& team = team_ != nullptr ? *team_ : alone;
  Eigen::VectorXd f_int;
  BlockValues tangent;
  kernel_.evaluate(x, f_int, tangent, team);
  using Turn = Eigen::Matrix<double, 12, 3>;
  for (const Tet4& element : elements_) {
    const Local local = localise(element, x);
    const Eigen::Matrix3d Rt = local.R.transpose();
    const Eigen::Matrix3d S = Rt * local.F;
    const Eigen::Matrix3d T = S.trace() * Eigen::Matrix3d::Identity() - S;
    const Eigen::Matrix3d RT_inverse = local.R * T.inverse();
    Turn arms;
    for (int i = 0; i < 4; ++i) {
      const Eigen::Index node = 3 * element.nodes[static_cast<std::size_t>(i)];
      arms.middleRows<3>(3 * i) =
          cross_matrix(Rt * (x.segment<3>(node) - x.segment<3>(3 * element.nodes[0])));
    }
    // Eigen's blocked product does not pay for matrices of this size.
    const Vector12d q = element.K.lazyProduct(local.u);
    const Turn of_turn = element.K.lazyProduct(arms);
    // In W, with ω turned there as well.
    std::array<Eigen::Matrix3d, 4> forces;
    std::array<Eigen::Matrix3d, 4> turns;
    for (int i = 0; i < 4; ++i) {
      forces[static_cast<std::size_t>(i)] =
          local.R * (of_turn.middleRows<3>(3 * i) - cross_matrix(q.segment<3>(3 * i))) * Rt;
      turns[static_cast<std::size_t>(i)] =
          RT_inverse * cross_matrix(element.gradients.row(i).transpose()) * Rt;
    }
    for (std::size_t k = 0; k < 16; ++k) {
      block(tangent, element.blocks[k]) += forces[k / 4] * turns[k % 4];
    }
  }
  return multiply_columns(pattern_, tangent, dx, team);
}

double CorotationalTet4::energy(const Eigen::VectorXd& x) const {
  double sum = 0.0;
  for (const Tet4& element : elements_) {
    const Vector12d u = localise(element, x).u;
    sum += 0.5 * u.dot(element.K * u);
  }
  return sum;
}

std::vector<ElementResult> CorotationalTet4::element_results(const Eigen::VectorXd& x) const {
  std::vector<ElementResult> results;
  results.reserve(elements_.size());
  for (const Tet4& element : elements_) {
    const Local local = localise(element, x);
    const Eigen::Matrix<double, 6, 1> s = D_ * (strain_matrix(element.gradients) * local.u);
    const double normal = (s(0) - s(1)) * (s(0) - s(1)) + (s(1) - s(2)) * (s(1) - s(2)) +
                          (s(2) - s(0)) * (s(2) - s(0));
    const double von_mises = std::sqrt(0.5 * normal + 3.0 * s.tail<3>().squaredNorm());
    const double angle = Eigen::AngleAxisd(local.R).angle();
    results.push_back({von_mises, angle});
  }
  return results;
}

}  // namespace tandem::fem
