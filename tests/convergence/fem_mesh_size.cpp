#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "fem_process/elements/make_formulation.h"
#include "fem_process/matrix/node_vectors.h"
#include "fem_process/mesh/tet10.h"
#include "fem_process/solvers/cholmod_solver.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

// u = ∇φ with a harmonic φ = sin(x) sin(2 y) sinh(√5 z) has neither divergence nor Laplacian:
// Navier's equation without volume forces, for every isotropic material.
Eigen::Vector3d harmonic_gradient(const Eigen::Vector3d& X) {
  const double k = std::sqrt(5.0);
  const double x = X.x();
  const double y = 2.0 * X.y();
  const double z = k * X.z();
  return {std::cos(x) * std::sin(y) * std::sinh(z), 2.0 * std::sin(x) * std::cos(y) * std::sinh(z),
          k * std::sin(x) * std::sin(y) * std::cosh(z)};
}

/// The exact positions: turned as a whole by R, and displaced so little that every formulation is
/// the linear one about R.
constexpr double kAmplitude = 1e-6;
Eigen::Vector3d exact(const Eigen::Matrix3d& R, const Eigen::Vector3d& X) {
  return R * (X + kAmplitude * harmonic_gradient(X));
}

/// √∫ |x_h − x|² dV over the unit cube, relative to the amplitude.
double error(const TetMesh& mesh, const Eigen::Matrix3d& R, const Eigen::VectorXd& x) {
  double sum = 0.0;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const double volume = signed_volume(mesh, mesh.tets[e]);
    const std::vector<int> nodes = mesh.element(e);
    for (const TetPoint& point : tet_rule_of_degree_5()) {
      const Eigen::VectorXd N =
          mesh.second_order() ? Eigen::VectorXd(tet10_shape(point.L)) : Eigen::VectorXd(point.L);
      Eigen::Vector3d X = Eigen::Vector3d::Zero();
      Eigen::Vector3d x_h = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        X += N(static_cast<Eigen::Index>(i)) * mesh.X[static_cast<std::size_t>(nodes[i])];
        x_h += N(static_cast<Eigen::Index>(i)) * x.segment<3>(3 * nodes[i]);
      }
      sum += point.weight * volume * (x_h - exact(R, X)).squaredNorm();
    }
  }
  return std::sqrt(sum) / kAmplitude;
}

/// Solves with the exact positions prescribed on the outside, by one linear solve from R X.
double solution_error(FormulationKind kind, int order, int cells) {
  const TetMesh mesh =
      read_mesh({.file = temporary_file("cube.inp", cube_inp(cells)), .order = order});
  const Eigen::Matrix3d R = kind == FormulationKind::Linear
                                ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                : rotation({0.3, -0.8, 1.2}).toRotationMatrix();
  Eigen::VectorXd x(3 * mesh.nodes());
  Eigen::VectorXd change = Eigen::VectorXd::Zero(x.size());
  std::vector<int> inner;
  for (int i = 0; i < mesh.nodes(); ++i) {
    const Eigen::Vector3d& X = mesh.X[static_cast<std::size_t>(i)];
    x.segment<3>(3 * i) = R * X;
    if (X.minCoeff() > 1e-9 && X.maxCoeff() < 1.0 - 1e-9) {
      inner.push_back(i);
    } else {
      change.segment<3>(3 * i) = exact(R, X) - R * X;
    }
  }
  const Material material{.young_Pa = 1.0, .poisson = 0.3};
  const auto formulation = make_formulation(kind, mesh, material);
  Eigen::VectorXd f;
  BlockValues K;
  formulation->evaluate(x, f, K);
  const SubPattern interior = sub_pattern(formulation->pattern(), inner);
  BlockValues K_II(9 * interior.pattern.blocks());
  for (std::size_t b = 0; b < interior.source.size(); ++b) {
    block(K_II, static_cast<int>(b)) = block(K, interior.source[b]);
  }
  CholmodSolver solver(interior.pattern);
  EXPECT_EQ(solver.factorize(K_II).outcome, Outcome::Done);
  Eigen::MatrixXd right = -gather(multiply(formulation->pattern(), K, change), inner);
  solver.solve(right, Eigen::VectorXd::Constant(1, right.norm()));
  scatter_add(right.col(0), inner, change);
  return error(mesh, R, x + change);
}

// Displacements converge as h² and h³ in the mean square [Strang & Fix 1973], two-sided, in every
// formulation about a turned state.
TEST(FemMeshSize, FirstOrderTetsConvergeAsTheSquareAndSecondOrderOnesAsTheCube) {
  for (FormulationKind kind :
       {FormulationKind::Linear, FormulationKind::Corotational,
        FormulationKind::ConsistentCorotational, FormulationKind::TotalLagrangian}) {
    for (int order : {1, 2}) {
      SCOPED_TRACE(std::to_string(static_cast<int>(kind)) + ", order " + std::to_string(order));
      const int coarsest = order == 1 ? 3 : 2;
      double last = solution_error(kind, order, coarsest);
      for (int level = 1; level < 3; ++level) {
        const double now = solution_error(kind, order, coarsest << level);
        EXPECT_NEAR(std::log2(last / now), order + 1.0, 0.15) << "halving " << level;
        last = now;
      }
    }
  }
}

}  // namespace
}  // namespace tandem::fem
