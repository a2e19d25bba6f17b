#include "fem_process/mesh/tet10.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tandem::fem {
namespace {

void add_orbit_of_4(std::vector<TetPoint>& rule, double a, double weight) {
  for (int k = 0; k < 4; ++k) {
    Eigen::Vector4d L = Eigen::Vector4d::Constant(a);
    L(k) = 1.0 - 3.0 * a;
    rule.push_back({L, weight});
  }
}

void add_orbit_of_6(std::vector<TetPoint>& rule, double a, double weight) {
  for (const auto& edge : kTetEdges) {
    Eigen::Vector4d L = Eigen::Vector4d::Constant(a);
    L(static_cast<Eigen::Index>(edge[0])) = 0.5 - a;
    L(static_cast<Eigen::Index>(edge[1])) = 0.5 - a;
    rule.push_back({L, weight});
  }
}

}  // namespace

std::size_t edge_between(std::size_t a, std::size_t b) {
  std::size_t k = 0;
  while (k < 5 && !((kTetEdges[k][0] == a && kTetEdges[k][1] == b) ||
                    (kTetEdges[k][0] == b && kTetEdges[k][1] == a))) {
    ++k;
  }
  return k;
}

Eigen::Matrix<double, 10, 1> tet10_shape(const Eigen::Vector4d& L) {
  Eigen::Matrix<double, 10, 1> N;
  for (int i = 0; i < 4; ++i) N(i) = L(i) * (2.0 * L(i) - 1.0);
  for (int k = 0; k < 6; ++k) {
    const auto& edge = kTetEdges[k];
    N(4 + k) = 4.0 * L(static_cast<Eigen::Index>(edge[0])) * L(static_cast<Eigen::Index>(edge[1]));
  }
  return N;
}

Eigen::Matrix<double, 10, 3> tet10_derivatives(const Eigen::Vector4d& L) {
  Eigen::Matrix<double, 10, 4> dN = Eigen::Matrix<double, 10, 4>::Zero();
  for (int i = 0; i < 4; ++i) dN(i, i) = 4.0 * L(i) - 1.0;
  for (int k = 0; k < 6; ++k) {
    const auto a = static_cast<Eigen::Index>(kTetEdges[k][0]);
    const auto b = static_cast<Eigen::Index>(kTetEdges[k][1]);
    dN(4 + k, a) = 4.0 * L(b);
    dN(4 + k, b) = 4.0 * L(a);
  }
  return dN.rightCols<3>().colwise() - dN.col(0);
}

const std::array<TetPoint, 4>& tet_rule_of_degree_2() {
  static const std::array<TetPoint, 4> rule = [] {
    std::vector<TetPoint> points;
    add_orbit_of_4(points, (5.0 - std::sqrt(5.0)) / 20.0, 0.25);
    std::array<TetPoint, 4> result;
    std::copy(points.begin(), points.end(), result.begin());
    return result;
  }();
  return rule;
}

const std::vector<TetPoint>& tet_rule_of_degree_5() {
  static const std::vector<TetPoint> rule = [] {
    std::vector<TetPoint> points;
    add_orbit_of_4(points, 0.31088591926330060980, 0.11268792571801585080);
    add_orbit_of_4(points, 0.092735250310891226402, 0.073493043116361949544);
    add_orbit_of_6(points, 0.045503704125649649492, 0.042546020777081466438);
    return points;
  }();
  return rule;
}

Eigen::Matrix<double, 10, 3> tet10_positions(const TetMesh& mesh, std::size_t element) {
  Eigen::Matrix<double, 10, 3> X;
  for (std::size_t k = 0; k < 4; ++k) {
    X.row(static_cast<Eigen::Index>(k)) =
        mesh.X[static_cast<std::size_t>(mesh.tets[element][k])].transpose();
  }
  for (std::size_t k = 0; k < 6; ++k) {
    X.row(static_cast<Eigen::Index>(4 + k)) =
        mesh.X[static_cast<std::size_t>(mesh.mids[element][k])].transpose();
  }
  return X;
}

double volume(const TetMesh& mesh, std::size_t element) {
  if (!mesh.second_order()) return signed_volume(mesh, mesh.tets[element]);
  const Eigen::Matrix<double, 10, 3> X = tet10_positions(mesh, element);
  double sum = 0.0;
  for (const TetPoint& point : tet_rule_of_degree_5()) {
    sum += point.weight * (X.transpose() * tet10_derivatives(point.L)).determinant() / 6.0;
  }
  return sum;
}

SmallestJacobian smallest_jacobian(const Eigen::Matrix<double, 10, 3>& X) {
  const double straight = (X.middleRows<3>(1).rowwise() - X.row(0)).determinant();
  const auto relative = [&](const Eigen::Vector4d& L) {
    return (X.transpose() * tet10_derivatives(L)).determinant() / straight;
  };
  SmallestJacobian smallest;
  for (const TetPoint& point : tet_rule_of_degree_2()) {
    smallest.at_points = std::min(smallest.at_points, relative(point.L));
  }
  for (int k = 0; k < 4; ++k) {
    smallest.at_nodes = std::min(smallest.at_nodes, relative(Eigen::Vector4d::Unit(k)));
  }
  for (const auto& edge : kTetEdges) {
    const Eigen::Vector4d middle =
        0.5 * (Eigen::Vector4d::Unit(static_cast<Eigen::Index>(edge[0])) +
               Eigen::Vector4d::Unit(static_cast<Eigen::Index>(edge[1])));
    smallest.at_nodes = std::min(smallest.at_nodes, relative(middle));
  }
  return smallest;
}

}  // namespace tandem::fem
