#include "fem_process/elements/mass.h"

#include <Eigen/Dense>

#include "fem_process/mesh/tet10.h"

namespace tandem::fem {
namespace {

/// ∫ N_i N_j dV (m³).
Eigen::MatrixXd shape_products(const TetMesh& mesh, std::size_t e) {
  if (!mesh.second_order()) {
    const double unit = signed_volume(mesh, mesh.tets[e]) / 20.0;
    Eigen::MatrixXd products = Eigen::MatrixXd::Constant(4, 4, unit);
    products.diagonal() *= 2.0;
    return products;
  }
  const Eigen::Matrix<double, 10, 3> X = tet10_positions(mesh, e);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(10, 10);
  for (const TetPoint& point : tet_rule_of_degree_5()) {
    const Eigen::Matrix<double, 10, 1> N = tet10_shape(point.L);
    const Eigen::Matrix3d J = X.transpose() * tet10_derivatives(point.L);
    products += point.weight * J.determinant() / 6.0 * N * N.transpose();
  }
  return products;
}

Eigen::MatrixXd lumped(const Eigen::MatrixXd& consistent) {
  const Eigen::VectorXd diagonal = consistent.diagonal();
  return Eigen::MatrixXd((diagonal * (consistent.sum() / diagonal.sum())).asDiagonal());
}

}  // namespace

std::vector<double> mass_matrix(const TetMesh& mesh, const BlockPattern& pattern,
                                const Materials& materials, MassKind kind) {
  std::vector<double> values(pattern.blocks(), 0.0);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    Eigen::MatrixXd M = materials.of(e).density_kg_per_m3 * shape_products(mesh, e);
    if (kind == MassKind::Lumped) M = lumped(M);
    const std::vector<int> nodes = mesh.element(e);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      for (std::size_t j = 0; j < nodes.size(); ++j) {
        values[static_cast<std::size_t>(pattern.find(nodes[i], nodes[j]))] +=
            M(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      }
    }
  }
  return values;
}

std::vector<double> nodal_masses(const BlockPattern& pattern, const std::vector<double>& mass) {
  std::vector<double> sums(static_cast<std::size_t>(pattern.rows()), 0.0);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      sums[i] += mass[static_cast<std::size_t>(b)];
    }
  }
  return sums;
}

}  // namespace tandem::fem
