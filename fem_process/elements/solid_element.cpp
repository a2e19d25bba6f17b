#include "fem_process/elements/solid_element.h"

#include <Eigen/Dense>

#include "fem_process/matrix/tet4.h"
#include "fem_process/mesh/tet10.h"

namespace tandem::fem {
namespace {

void set_points(const TetMesh& mesh, const BlockPattern& pattern, std::size_t e,
                SolidElement<4>& element) {
  const TetShape shape = make_tet_shape(mesh, mesh.tets[e], pattern);
  element.points[0] = {shape.gradients, shape.volume};
}

void set_points(const TetMesh& mesh, const BlockPattern& /*pattern*/, std::size_t e,
                SolidElement<10>& element) {
  const Eigen::Matrix<double, 10, 3> X = tet10_positions(mesh, e);
  for (std::size_t k = 0; k < element.points.size(); ++k) {
    const TetPoint& at = tet_rule_of_degree_2()[k];
    const Eigen::Matrix<double, 10, 3> dN = tet10_derivatives(at.L);
    const Eigen::Matrix3d J = X.transpose() * dN;  // ∂X/∂L
    element.points[k] = {dN * J.inverse(), at.weight * J.determinant() / 6.0};
  }
}

}  // namespace

template <int N>
auto SolidElement<N>::differences(const Eigen::VectorXd& x) const -> Differences {
  Differences d;
  const auto origin = x.segment<3>(3 * nodes[0]);
  for (int k = 1; k < N; ++k) {
    d.col(k - 1) = x.segment<3>(3 * nodes[static_cast<std::size_t>(k)]) - origin;
  }
  return d;
}

template <int N>
void SolidElement<N>::add_forces(const Point& point, const Eigen::Matrix3d& P,
                                 Eigen::VectorXd& f) const {
  for (int i = 0; i < N; ++i) {
    f.segment<3>(3 * nodes[static_cast<std::size_t>(i)]) +=
        point.volume * (P * point.gradients.row(i).transpose());
  }
}

template <int N>
void SolidElement<N>::add_stiffness(const Point& point, const Tangent& A, Stiffness& K) {
  for (int j = 1; j < N; ++j) {
    const Eigen::Vector3d g_j = point.volume * point.gradients.row(j).transpose();
    const Eigen::Matrix<double, 9, 3> T = g_j(0) * A.template leftCols<3>() +
                                          g_j(1) * A.template middleCols<3>(3) +
                                          g_j(2) * A.template rightCols<3>();
    for (int i = 1; i <= j; ++i) {
      const auto g_i = point.gradients.row(i);
      K.template block<3, 3>(3 * i - 3, 3 * j - 3) += g_i(0) * T.template topRows<3>() +
                                                      g_i(1) * T.template middleRows<3>(3) +
                                                      g_i(2) * T.template bottomRows<3>();
    }
  }
}

template <int N>
void SolidElement<N>::add_to_pattern(const Stiffness& upper, BlockValues& K) const {
  const auto at = [this](int i, int j) { return blocks[static_cast<std::size_t>(N * i + j)]; };
  Eigen::Matrix3d sum_0 = Eigen::Matrix3d::Zero();
  std::array<Eigen::Matrix3d, N> sum;  // Σ_i K_ij: minus K_0j
  sum.fill(Eigen::Matrix3d::Zero());
  for (int i = 1; i < N; ++i) {
    for (int j = i; j < N; ++j) {
      Eigen::Matrix3d K_ij = upper.template block<3, 3>(3 * i - 3, 3 * j - 3);
      if (i == j) K_ij = (0.5 * (K_ij + K_ij.transpose())).eval();
      block(K, at(i, j)) += K_ij;
      sum[static_cast<std::size_t>(j)] += K_ij;
      if (i == j) continue;
      block(K, at(j, i)) += K_ij.transpose();
      sum[static_cast<std::size_t>(i)] += K_ij.transpose();
    }
  }
  for (int j = 1; j < N; ++j) {
    const Eigen::Matrix3d& sum_j = sum[static_cast<std::size_t>(j)];
    block(K, at(0, j)) -= sum_j;
    block(K, at(j, 0)) -= sum_j.transpose();
    sum_0 += sum_j;
  }
  block(K, at(0, 0)) += 0.5 * (sum_0 + sum_0.transpose());
}

template <int N>
std::vector<SolidElement<N>> make_elements(const TetMesh& mesh, const BlockPattern& pattern) {
  std::vector<SolidElement<N>> elements(mesh.tets.size());
  for (std::size_t e = 0; e < elements.size(); ++e) {
    SolidElement<N>& element = elements[e];
    const std::vector<int> nodes = mesh.element(e);
    for (std::size_t i = 0; i < N; ++i) {
      element.nodes[i] = nodes[i];
      for (std::size_t j = 0; j < N; ++j) {
        element.blocks[N * i + j] = pattern.find(nodes[i], nodes[j]);
      }
    }
    set_points(mesh, pattern, e, element);
  }
  return elements;
}

template struct SolidElement<4>;
template struct SolidElement<10>;
template std::vector<SolidElement<4>> make_elements<4>(const TetMesh&, const BlockPattern&);
template std::vector<SolidElement<10>> make_elements<10>(const TetMesh&, const BlockPattern&);

}  // namespace tandem::fem
