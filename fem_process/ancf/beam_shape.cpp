#include "fem_process/ancf/beam_shape.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace tandem::fem::ancf {
namespace {

using ScalarMass = Eigen::Matrix<double, kVectors, kVectors>;

void set_symmetric(ScalarMass& m, int a, int b, double value) {
  m(a, b) = value;
  m(b, a) = value;
}

}  // namespace

Eigen::Matrix<double, kVectors, 1> shape_values(double length_m, double xi, double y, double z) {
  const double xi2 = xi * xi;
  const double xi3 = xi2 * xi;
  Eigen::Matrix<double, kVectors, 1> s;
  s << 1.0 - 3.0 * xi2 + 2.0 * xi3, length_m * (xi - 2.0 * xi2 + xi3), y * (1.0 - xi),
      z * (1.0 - xi), 3.0 * xi2 - 2.0 * xi3, length_m * (xi3 - xi2), y * xi, z * xi;
  return s;
}

Eigen::Matrix<double, kVectors, 3> shape_gradients(double length_m, double xi, double y, double z) {
  Eigen::Matrix<double, kVectors, 3> gradient = Eigen::Matrix<double, kVectors, 3>::Zero();
  gradient(0, 0) = 6.0 * (xi * xi - xi) / length_m;
  gradient(1, 0) = 1.0 - 4.0 * xi + 3.0 * xi * xi;
  gradient(4, 0) = -gradient(0, 0);
  gradient(5, 0) = 3.0 * xi * xi - 2.0 * xi;
  gradient.row(2) << -y / length_m, 1.0 - xi, 0.0;
  gradient.row(3) << -z / length_m, 0.0, 1.0 - xi;
  gradient.row(6) << y / length_m, xi, 0.0;
  gradient.row(7) << z / length_m, 0.0, xi;
  return gradient;
}

StressFree stress_free(const BeamVectors& reference, double length_m, double xi, double y,
                       double z) {
  const Eigen::Matrix3d J0 = reference * shape_gradients(length_m, xi, y, z);
  Eigen::Matrix3d axes;
  axes.col(2) = J0.col(2).normalized();
  axes.col(0) = J0.col(1).cross(J0.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  const auto area = [&](int slot) {
    return Eigen::Vector3d(reference.col(slot))
        .cross(Eigen::Vector3d(reference.col(slot + 1)))
        .norm();
  };
  const double between = (1.0 - xi) * area(2) + xi * area(6);
  const double here = Eigen::Vector3d(J0.col(1)).cross(Eigen::Vector3d(J0.col(2))).norm();
  return {.inverse = J0.inverse() * axes, .volume = J0.determinant() * between / here};
}

Eigen::Matrix3d assumed_metric(const BeamVectors& e, double length_m, double xi, double y,
                               double z) {
  const Eigen::Matrix3d J = e * shape_gradients(length_m, xi, y, z);
  Eigen::Matrix3d C = J.transpose() * J;
  const Eigen::Matrix<double, 3, 2> first = e.middleCols<2>(2);
  const Eigen::Matrix<double, 3, 2> second = e.middleCols<2>(6);
  C.bottomRightCorner<2, 2>() =
      (1.0 - xi) * first.transpose() * first + xi * second.transpose() * second;
  return C;
}

StressFree assumed_stress_free(const BeamVectors& reference, double length_m, double xi, double y,
                               double z) {
  const Eigen::Matrix3d C0 = assumed_metric(reference, length_m, xi, y, z);
  // Lower triangular: its last axis along r_z, its first one normal to r_y and r_z.
  return {.inverse = Eigen::LLT<Eigen::Matrix3d>(C0.inverse()).matrixL(),
          .volume = std::sqrt(C0.determinant())};
}

GaussRule gauss_rule(int n) {
  GaussRule rule;
  for (int i = n; i >= 1; --i) {
    double x = std::cos(std::numbers::pi * (i - 0.25) / (n + 0.5));
    double slope = 1.0;
    // Newton's iteration on the Legendre polynomial P_n: quadratic from this start.
    for (int step = 0; step < 10; ++step) {
      double p = 1.0;
      double before = 0.0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k;
        before = p;
        p = next;
      }
      slope = n * (x * p - before) / (x * x - 1.0);
      x -= p / slope;
    }
    rule.point.push_back(0.5 * (1.0 + x));
    rule.weight.push_back(1.0 / ((1.0 - x * x) * slope * slope));
  }
  return rule;
}

ScalarMass mass_matrix(double density_kg_per_m3, double length_m, const BeamSection& section) {
  const double l = length_m;
  const double mass = density_kg_per_m3 * l * section.area_m2();
  const double w2 = section.width_m * section.width_m;
  const double h2 = section.height_m * section.height_m;
  ScalarMass m = ScalarMass::Zero();
  m(0, 0) = m(4, 4) = 13.0 * mass / 35.0;
  set_symmetric(m, 0, 1, 11.0 * mass * l / 210.0);
  set_symmetric(m, 0, 4, 9.0 * mass / 70.0);
  set_symmetric(m, 0, 5, -13.0 * mass * l / 420.0);
  m(1, 1) = m(5, 5) = mass * l * l / 105.0;
  set_symmetric(m, 1, 4, 13.0 * mass * l / 420.0);
  set_symmetric(m, 1, 5, -mass * l * l / 140.0);
  set_symmetric(m, 4, 5, -11.0 * mass * l / 210.0);
  m(2, 2) = m(6, 6) = mass * w2 / 36.0;
  set_symmetric(m, 2, 6, mass * w2 / 72.0);
  m(3, 3) = m(7, 7) = mass * h2 / 36.0;
  set_symmetric(m, 3, 7, mass * h2 / 72.0);
  return m;
}

ScalarMass mass_matrix(double density_kg_per_m3, double length_m, const BeamSection& section,
                       const BeamVectors& reference) {
  ScalarMass m = ScalarMass::Zero();
  // s_a s_b has degree 6 along x and 2 across, det J₀ up to degree 5 and 2, over the root of a
  // polynomial that is near one.
  const GaussRule along = gauss_rule(6);
  const GaussRule across = gauss_rule(3);
  for (std::size_t i = 0; i < along.point.size(); ++i) {
    for (std::size_t j = 0; j < across.point.size(); ++j) {
      for (std::size_t k = 0; k < across.point.size(); ++k) {
        const double y = section.width_m * (across.point[j] - 0.5);
        const double z = section.height_m * (across.point[k] - 0.5);
        const double volume = stress_free(reference, length_m, along.point[i], y, z).volume;
        const auto s = shape_values(length_m, along.point[i], y, z);
        m += density_kg_per_m3 * along.weight[i] * across.weight[j] * across.weight[k] * length_m *
             section.area_m2() * volume * s * s.transpose();
      }
    }
  }
  return m;
}

}  // namespace tandem::fem::ancf
