#include "fem_process/mesh/surface.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>

namespace tandem::fem {
namespace {

/// A point of a rule for integrals over a triangle; the weights sum to 1.
struct TrianglePoint {
  Eigen::Vector3d L;
  double weight = 0.0;
};

/// Exact for polynomials of degree 5 [Radon 1948].
const std::array<TrianglePoint, 7>& rule_of_degree_5() {
  static const std::array<TrianglePoint, 7> rule = [] {
    std::array<TrianglePoint, 7> points;
    points[0] = {Eigen::Vector3d::Constant(1.0 / 3.0), 0.225};
    const double root = std::sqrt(15.0);
    for (std::size_t k = 0; k < 2; ++k) {
      const double sign = k == 0 ? -1.0 : 1.0;
      const double a = (6.0 + sign * root) / 21.0;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        TrianglePoint& point = points[1 + 3 * k + corner];
        point = {Eigen::Vector3d::Constant(a), (155.0 + sign * root) / 1200.0};
        point.L(static_cast<Eigen::Index>(corner)) = 1.0 - 2.0 * a;
      }
    }
    return points;
  }();
  return rule;
}

void add_first_order(const TetMesh& mesh, const Triangle& corners, std::vector<double>& areas) {
  const double third = area(mesh, corners) / 3.0;
  for (int node : corners) areas[static_cast<std::size_t>(node)] += third;
}

/// N_i = L_i (2 L_i − 1) at corners, 4 L_a L_b at mid nodes; dA = ½ |∂X/∂L_1 × ∂X/∂L_2|.
void add_second_order(const TetMesh& mesh, const Triangle& corners, const Triangle& mids,
                      std::vector<double>& areas) {
  Eigen::Matrix<double, 3, 6> X;
  for (std::size_t k = 0; k < 3; ++k) {
    X.col(static_cast<Eigen::Index>(k)) = mesh.X[static_cast<std::size_t>(corners[k])];
    X.col(static_cast<Eigen::Index>(3 + k)) = mesh.X[static_cast<std::size_t>(mids[k])];
  }
  for (const TrianglePoint& point : rule_of_degree_5()) {
    const Eigen::Vector3d& L = point.L;
    Eigen::Matrix<double, 6, 1> N;
    Eigen::Matrix<double, 6, 3> dN = Eigen::Matrix<double, 6, 3>::Zero();
    for (int i = 0; i < 3; ++i) {
      const int next = (i + 1) % 3;
      N(i) = L(i) * (2.0 * L(i) - 1.0);
      N(3 + i) = 4.0 * L(i) * L(next);
      dN(i, i) = 4.0 * L(i) - 1.0;
      dN(3 + i, i) = 4.0 * L(next);
      dN(3 + i, next) = 4.0 * L(i);
    }
    const Eigen::Vector3d along_1 = X * (dN.col(1) - dN.col(0));
    const Eigen::Vector3d along_2 = X * (dN.col(2) - dN.col(0));
    const double dA = point.weight * 0.5 * along_1.cross(along_2).norm();
    for (std::size_t k = 0; k < 3; ++k) {
      areas[static_cast<std::size_t>(corners[k])] += N(static_cast<Eigen::Index>(k)) * dA;
      areas[static_cast<std::size_t>(mids[k])] += N(static_cast<Eigen::Index>(3 + k)) * dA;
    }
  }
}

}  // namespace

std::vector<double> nodal_areas(const TetMesh& mesh, const NodeSet& surface) {
  std::vector<double> areas(mesh.X.size(), 0.0);
  for (std::size_t k = 0; k < surface.triangles.size(); ++k) {
    if (mesh.second_order()) {
      add_second_order(mesh, surface.triangles[k], surface.triangle_mids[k], areas);
    } else {
      add_first_order(mesh, surface.triangles[k], areas);
    }
  }
  return areas;
}

}  // namespace tandem::fem
