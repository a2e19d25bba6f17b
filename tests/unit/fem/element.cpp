#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <map>
#include <random>

#include "fem_process/elements/corotational_tet4.h"
#include "fem_process/kernels/polar.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

const Material kSoft{.young_Pa = 5e6, .poisson = 0.3, .density_kg_per_m3 = 1000.0};

TetMesh bar() { return read_mesh({.file = data_file("bar.msh")}); }

Eigen::VectorXd mapped(const TetMesh& mesh, const Eigen::Matrix3d& A, const Eigen::Vector3d& b) {
  Eigen::VectorXd x(3 * mesh.nodes());
  for (int i = 0; i < mesh.nodes(); ++i) {
    x.segment<3>(3 * i) = A * mesh.X[static_cast<std::size_t>(i)] + b;
  }
  return x;
}

Eigen::VectorXd noisy(const TetMesh& mesh, const Eigen::Matrix3d& A, double amplitude) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  Eigen::VectorXd x = mapped(mesh, A, Eigen::Vector3d::Zero());
  for (double& value : x) value += uniform(random);
  return x;
}

Eigen::VectorXd internal_force(const Formulation& formulation, const Eigen::VectorXd& x) {
  Eigen::VectorXd f;
  BlockValues K;
  formulation.evaluate(x, f, K);
  return f;
}

/// Nodes none of whose faces lies on the surface: those of no triangle that one tet alone has.
std::vector<int> inner_nodes(const TetMesh& mesh) {
  std::map<std::array<int, 3>, int> uses;
  for (const Tet& tet : mesh.tets) {
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::array<int, 3> face{};
      for (std::size_t k = 0, at = 0; k < 4; ++k) {
        if (k != skip) face[at++] = tet[k];
      }
      std::sort(face.begin(), face.end());
      ++uses[face];
    }
  }
  std::vector<bool> outside(mesh.X.size(), false);
  for (const auto& [face, count] : uses) {
    for (int node : face) {
      if (count == 1) outside[static_cast<std::size_t>(node)] = true;
    }
  }
  std::vector<int> inner;
  for (int i = 0; i < mesh.nodes(); ++i) {
    if (!outside[static_cast<std::size_t>(i)]) inner.push_back(i);
  }
  return inner;
}

TEST(FemPolar, IsARotationThatLeavesASymmetricStretch) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int k = 0; k < 200; ++k) {
    const Eigen::Matrix3d F = Eigen::Matrix3d::NullaryExpr([&] { return uniform(random); });
    const PolarRotation polar = polar_rotation(F);
    EXPECT_LT((polar.R.transpose() * polar.R - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_GT(polar.R.determinant(), 0.0);
    const Eigen::Matrix3d U = polar.R.transpose() * F;
    EXPECT_LT((U - U.transpose()).norm(), 2e-14);
    EXPECT_EQ(polar.inverted, F.determinant() <= 0.0);
  }
}

TEST(FemPolar, GivesARotationForSingularAndZeroGradients) {
  for (const Eigen::Vector3d& stretch : {Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(1, 0, 0),
                                         Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, -1)}) {
    const PolarRotation polar = polar_rotation(stretch.asDiagonal());
    EXPECT_TRUE(polar.inverted);
    EXPECT_NEAR(polar.R.determinant(), 1.0, 1e-14);
  }
}

// Round-off of the edges is ε · 10 m (the distance from the origin); times the stiffness of an
// element, about E · 0.03 m = 1.5e5 N/m: 1e-16 · 10 · 1.5e5 = 1.5e-10 N per element.
TEST(FemElement, RigidMotionGivesNoForce) {
  const TetMesh mesh = bar();
  const CorotationalTet4 formulation(mesh, kSoft);
  for (const Eigen::Vector3d& turn : {Eigen::Vector3d(0.1, -0.2, 0.3), Eigen::Vector3d(0, 0, M_PI),
                                      Eigen::Vector3d(2, 1, -2), Eigen::Vector3d(0, 0, 0)}) {
    const Eigen::VectorXd x =
        mapped(mesh, rotation(turn).toRotationMatrix(), Eigen::Vector3d(3, -10, 2));
    EXPECT_LT(internal_force(formulation, x).cwiseAbs().maxCoeff(), 2e-9);
    EXPECT_LT(formulation.energy(x), 1e-18);
  }
}

// A uniform deformation gradient gives a uniform stress: nodes inside are in balance, whatever the
// deformation and the mesh. Forces on the surface are E · strain · area = 5e6 · 0.3 · 1e-3 N.
TEST(FemElement, PatchTestHoldsForAnyUniformDeformation) {
  const TetMesh mesh = read_mesh({.file = data_file("lug.msh"), .length_scale_m = 1e-3});
  const std::vector<int> inner = inner_nodes(mesh);
  ASSERT_GT(inner.size(), 5U);
  const CorotationalTet4 formulation(mesh, kSoft);
  Eigen::Matrix3d A;
  A << 1.2, 0.3, 0.0, -0.1, 0.9, 0.2, 0.05, 0.0, 1.1;
  A = rotation({0.5, 1.0, -0.7}).toRotationMatrix() * A;
  const Eigen::VectorXd x = mapped(mesh, A, Eigen::Vector3d(1, 2, 3));
  const Eigen::VectorXd f = internal_force(formulation, x);
  for (int node : inner) {
    EXPECT_LT(f.segment<3>(3 * node).norm(), 1e-11 * f.cwiseAbs().maxCoeff());
  }
  // σ = 2 μ (U − I) + λ tr(U − I) I everywhere; von Mises stress √(3/2) ‖dev σ‖.
  const Eigen::Matrix3d strain = polar_rotation(A).R.transpose() * A - Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d deviator =
      5e6 / 1.3 * (strain - strain.trace() / 3.0 * Eigen::Matrix3d::Identity());
  for (const ElementResult& element : formulation.element_results(x)) {
    EXPECT_NEAR(element.von_mises_Pa, std::sqrt(1.5) * deviator.norm(), 1e-7 * deviator.norm());
  }
}

// E = Σ V (μ |U − I|² + λ/2 tr²(U − I)): the hyperelastic law of the isotropic co-rotational tet.
TEST(FemElement, EnergyIsThatOfTheStretchTensor) {
  const TetMesh mesh = bar();
  const CorotationalTet4 formulation(mesh, kSoft);
  const Eigen::VectorXd x = noisy(mesh, rotation({1, 2, 0.5}).toRotationMatrix(), 2e-3);
  double expected = 0.0;
  for (const Tet& tet : mesh.tets) {
    Eigen::Matrix3d reference;
    Eigen::Matrix3d current;
    for (int k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(k) + 1;
      reference.col(k) =
          mesh.X[static_cast<std::size_t>(tet[corner])] - mesh.X[static_cast<std::size_t>(tet[0])];
      current.col(k) = x.segment<3>(3 * tet[corner]) - x.segment<3>(3 * tet[0]);
    }
    const Eigen::Matrix3d F = current * reference.inverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> squared_stretch(F.transpose() * F);
    const Eigen::Vector3d strain = squared_stretch.eigenvalues().array().sqrt() - 1.0;
    const double mu = 5e6 / 2.6;
    const double lambda = 5e6 * 0.3 / (1.3 * 0.4);
    expected += signed_volume(mesh, tet) *
                (mu * strain.squaredNorm() + 0.5 * lambda * strain.sum() * strain.sum());
  }
  EXPECT_NEAR(formulation.energy(x), expected, 1e-11 * expected);
}

// Central differences with 1e-6 m: truncation (δ/edge)² = (1e-6/0.03)² ~ 1e-9, round-off
// ε E_total/δ ~ 1e-16 · 10 J/1e-6 = 1e-9 N beside forces of 100 N.
TEST(FemElement, ForceIsTheGradientOfTheEnergy) {
  const TetMesh mesh = bar();
  const CorotationalTet4 formulation(mesh, kSoft);
  Eigen::VectorXd x = noisy(mesh, rotation({1, 2, 0.5}).toRotationMatrix(), 2e-3);
  const Eigen::VectorXd f = internal_force(formulation, x);
  const double delta = 1e-6;
  for (Eigen::Index i = 0; i < x.size(); i += 7) {
    const double at = x(i);
    x(i) = at + delta;
    const double above = formulation.energy(x);
    x(i) = at - delta;
    const double below = formulation.energy(x);
    x(i) = at;
    EXPECT_NEAR((above - below) / (2 * delta), f(i), 1e-7 * f.cwiseAbs().maxCoeff());
  }
}

TEST(FemElement, StiffnessIsSymmetricWithSixZeroModes) {
  const TetMesh mesh = bar();
  const CorotationalTet4 formulation(mesh, kSoft);
  const Eigen::VectorXd x = mapped(mesh, rotation({1, 2, 0.5}).toRotationMatrix(), {1, 0, 0});
  Eigen::VectorXd f;
  BlockValues K;
  formulation.evaluate(x, f, K);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(x.size(), x.size());
  const BlockPattern& pattern = formulation.pattern();
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int b = pattern.row_start[static_cast<std::size_t>(i)];
         b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
      dense.block<3, 3>(3 * i, 3 * pattern.column[static_cast<std::size_t>(b)]) = block(K, b);
    }
  }
  EXPECT_EQ((dense - dense.transpose()).cwiseAbs().maxCoeff(), 0.0);
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense, Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = values(values.size() - 1);
  EXPECT_LT(std::abs(values(0)), 1e-13 * largest);
  EXPECT_LT(values(5), 1e-13 * largest);
  EXPECT_GT(values(6), 1e-7 * largest);  // first bending mode: (edge/length)⁴ below the largest
}

// Mirroring the mesh inverts every tet: forces stay finite and push back.
TEST(FemElement, InvertedElementsAreCountedAndPushBack) {
  const TetMesh mesh = bar();
  const CorotationalTet4 formulation(mesh, kSoft);
  const Eigen::VectorXd x =
      mapped(mesh, Eigen::Vector3d(1, 1, -0.5).asDiagonal(), Eigen::Vector3d::Zero());
  Eigen::VectorXd f;
  BlockValues K;
  EXPECT_EQ(formulation.evaluate(x, f, K), static_cast<int>(mesh.tets.size()));
  ASSERT_TRUE(f.allFinite());
  // Moving along −f lowers the energy.
  EXPECT_LT(formulation.energy(x - 1e-7 * f), formulation.energy(x));
}

TEST(FemMass, BothKindsHaveTheMassOfTheVolume) {
  const TetMesh mesh = bar();
  const BlockPattern pattern = pattern_of(mesh);
  const double expected = 1000.0 * 0.5 * 0.05 * 0.05;  // a straight box: the mesh is exact
  for (MassKind kind : {MassKind::Lumped, MassKind::Consistent}) {
    double sum = 0.0;
    for (double m : mass_matrix(mesh, pattern, kSoft, kind)) sum += m;
    EXPECT_NEAR(sum, expected, 1e-12 * expected);
  }
  double sum = 0.0;
  for (double m : nodal_masses(pattern, mass_matrix(mesh, pattern, kSoft, MassKind::Consistent))) {
    sum += m;
  }
  EXPECT_NEAR(sum, expected, 1e-12 * expected);
}

}  // namespace
}  // namespace tandem::fem
