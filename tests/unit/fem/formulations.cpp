#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <tuple>

#include "fem_process/elements/make_formulation.h"
#include "fem_process/kernels/polar.h"
#include "fem_process/material/stress_law.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

const Material kSoft{.young_Pa = 5e6, .poisson = 0.3, .density_kg_per_m3 = 1000.0};

/// Wood-like, its axes turned out of those of the bar.
Material orthotropic() {
  Material material = kSoft;
  material.orthotropic = {.young_Pa = {5e6, 1e6, 0.6e6},
                          .poisson = {0.35, 0.4, 0.45},
                          .shear_Pa = {0.7e6, 0.8e6, 0.3e6},
                          .axes = rotation({0.4, -0.7, 1.1}).toRotationMatrix()};
  return material;
}

TetMesh bar(int order = 1) { return read_mesh({.file = data_file("bar.msh"), .order = order}); }

Eigen::VectorXd noise(Eigen::Index size, double amplitude, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  return Eigen::VectorXd::NullaryExpr(size, [&] { return uniform(random); });
}

/// Turned by about 2 rad and strained by about 10 %: nodes of second order are half as far apart,
/// and gradients at their integration points up to three times as large.
Eigen::VectorXd deformed(const TetMesh& mesh) {
  Eigen::VectorXd x = noise(3 * mesh.nodes(), mesh.second_order() ? 3e-4 : 2e-3, 7);
  const Eigen::Matrix3d R = rotation({1, 2, 0.5}).toRotationMatrix();
  for (int i = 0; i < mesh.nodes(); ++i) {
    x.segment<3>(3 * i) += R * mesh.X[static_cast<std::size_t>(i)];
  }
  return x;
}

struct Evaluated {
  Eigen::VectorXd f;
  BlockValues K;
};
Evaluated evaluated(const Formulation& formulation, const Eigen::VectorXd& x) {
  Evaluated result;
  formulation.evaluate(x, result.f, result.K);
  return result;
}

enum class Kind { Isotropic, Orthotropic };
using Case = std::tuple<FormulationKind, int, Kind>;  // the mesh's order in the middle

class FemFormulation : public ::testing::TestWithParam<Case> {
 protected:
  Material material = std::get<2>(GetParam()) == Kind::Isotropic ? kSoft : orthotropic();
  TetMesh mesh = bar(std::get<1>(GetParam()));
  std::unique_ptr<const Formulation> formulation =
      make_formulation(std::get<0>(GetParam()), mesh, material);
};
class FemConsistentFormulation : public FemFormulation {};
class FemNonlinearFormulation : public FemFormulation {};
class FemIsotropicFormulation : public FemFormulation {};

// Central differences with 1e-6 m of edges of 0.03 m: truncation (1e-6/0.03)² ~ 1e-9; round-off
// ε E_total/δ ~ 1e-16 · 10 J/1e-6 m = 1e-9 N beside forces of 100 N.
TEST_P(FemFormulation, ForceIsTheGradientOfTheEnergy) {
  Eigen::VectorXd x = deformed(mesh);
  const Eigen::VectorXd f = evaluated(*formulation, x).f;
  const double delta = 1e-6;
  for (Eigen::Index i = 0; i < x.size(); i += mesh.second_order() ? 97 : 7) {
    const double at = x(i);
    x(i) = at + delta;
    const double above = formulation->energy(x);
    x(i) = at - delta;
    const double below = formulation->energy(x);
    x(i) = at;
    EXPECT_NEAR((above - below) / (2 * delta), f(i), 1e-7 * f.cwiseAbs().maxCoeff());
  }
}

// f + K y changes along dx by derivative(): what the exact interface Jacobian rests on. Truncation
// and round-off as above, relative to forces of 100 N and differences of δ |K| ~ 1e-6 · 1e5 N.
TEST_P(FemFormulation, DirectionalDerivativeAgreesWithDifferences) {
  const Eigen::VectorXd x = deformed(mesh);
  const Eigen::VectorXd y = noise(x.size(), 1e-3, 11);
  const Eigen::VectorXd dx = noise(x.size(), 1.0, 13);
  const Eigen::VectorXd exact = formulation->derivative(x, y, dx);
  const double delta = 1e-7;
  const auto value = [&](double s) {
    const Evaluated at = evaluated(*formulation, x + s * dx);
    return Eigen::VectorXd(at.f + multiply(formulation->pattern(), at.K, y));
  };
  const Eigen::VectorXd differences = (value(delta) - value(-delta)) / (2 * delta);
  EXPECT_LT((exact - differences).norm(), 1e-7 * exact.norm());
}

TEST_P(FemFormulation, StiffnessIsExactlySymmetric) {
  const Evaluated at = evaluated(*formulation, deformed(mesh));
  const BlockPattern& pattern = formulation->pattern();
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int b = pattern.row_start[static_cast<std::size_t>(i)];
         b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
      const int j = pattern.column[static_cast<std::size_t>(b)];
      EXPECT_EQ((block(at.K, b) - block(at.K, pattern.find(j, i)).transpose()).norm(), 0.0);
    }
  }
}

// At rest all formulations are the linear one: stresses are 0 and R = I.
TEST_P(FemFormulation, StiffnessAtRestIsTheLinearOne) {
  Eigen::VectorXd X(3 * mesh.nodes());
  for (int i = 0; i < mesh.nodes(); ++i) X.segment<3>(3 * i) = mesh.X[static_cast<std::size_t>(i)];
  const auto linear = make_formulation(FormulationKind::Linear, mesh, material);
  const BlockValues expected = evaluated(*linear, X).K;
  const Evaluated found = evaluated(*formulation, X);
  double largest = 0.0;
  for (double value : expected) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(found.K[i], expected[i], 64 * 2.3e-16 * largest);
  }
  EXPECT_LT(found.f.cwiseAbs().maxCoeff(), 1e-16 * largest);
}

// Forces and moments of every element cancel, whatever its deformation: |f| ~ 100 N, arms of 0.5 m,
// about 1e3 element nodes, each with the round-off of the rotation.
TEST_P(FemNonlinearFormulation, ForcesAndMomentsCancel) {
  const Eigen::VectorXd x = deformed(mesh);
  const Eigen::VectorXd f = evaluated(*formulation, x).f;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    force += f.segment<3>(i);
    moment += Eigen::Vector3d(x.segment<3>(i)).cross(Eigen::Vector3d(f.segment<3>(i)));
  }
  EXPECT_LT(force.norm(), 1e-12 * f.norm());
  EXPECT_LT(moment.norm(), 1e-12 * f.norm());
}

// ε E l² · 20 elements at a node, as below.
TEST_P(FemNonlinearFormulation, RigidMotionGivesNoForce) {
  const Eigen::Matrix3d R = rotation({2.0, -1.0, 0.7}).toRotationMatrix();
  Eigen::VectorXd x(3 * mesh.nodes());
  for (int i = 0; i < mesh.nodes(); ++i) {
    x.segment<3>(3 * i) = R * mesh.X[static_cast<std::size_t>(i)] + Eigen::Vector3d(1, -2, 3);
  }
  EXPECT_LT(evaluated(*formulation, x).f.cwiseAbs().maxCoeff(), 1e-9);
}

TEST_P(FemIsotropicFormulation, VonMisesOfUniaxialTensionIsTheStress) {
  const double strain = 1e-6;
  Eigen::VectorXd x(3 * mesh.nodes());
  for (int i = 0; i < mesh.nodes(); ++i) {
    const Eigen::Vector3d& X = mesh.X[static_cast<std::size_t>(i)];
    x.segment<3>(3 * i) = X + strain * Eigen::Vector3d(X.x(), -0.3 * X.y(), -0.3 * X.z());
  }
  for (const ElementResult& element : formulation->element_results(x)) {
    EXPECT_NEAR(element.von_mises_Pa, 5e6 * strain, 1e-5 * 5e6 * strain);  // strain² is left out
  }
}

// Differences of forces: truncation (1e-6/0.03)² ~ 1e-9; round-off ε E l/δ = 2e-16 · 5e6 Pa ·
// 0.03 m/1e-6 m ~ 3e-5 N/m beside |K| ~ 1e5 N/m.
TEST_P(FemConsistentFormulation, StiffnessIsTheDerivativeOfTheForce) {
  const Eigen::VectorXd x = deformed(mesh);
  const Evaluated at = evaluated(*formulation, x);
  const double delta = 1e-6;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Eigen::VectorXd dx = noise(x.size(), 1.0, seed);
    const Eigen::VectorXd exact = multiply(formulation->pattern(), at.K, dx);
    const Eigen::VectorXd differences =
        (evaluated(*formulation, x + delta * dx).f - evaluated(*formulation, x - delta * dx).f) /
        (2 * delta);
    EXPECT_LT((exact - differences).norm(), 1e-7 * exact.norm());
  }
}

const auto kOrders = ::testing::Values(1, 2);
const auto kMaterials = ::testing::Values(Kind::Isotropic, Kind::Orthotropic);
const auto kKinds =
    ::testing::Values(FormulationKind::Linear, FormulationKind::Corotational,
                      FormulationKind::ConsistentCorotational, FormulationKind::TotalLagrangian);
INSTANTIATE_TEST_SUITE_P(All, FemFormulation, ::testing::Combine(kKinds, kOrders, kMaterials));
INSTANTIATE_TEST_SUITE_P(All, FemIsotropicFormulation,
                         ::testing::Combine(kKinds, kOrders, ::testing::Values(Kind::Isotropic)));
INSTANTIATE_TEST_SUITE_P(
    All, FemNonlinearFormulation,
    ::testing::Combine(::testing::Values(FormulationKind::Corotational,
                                         FormulationKind::ConsistentCorotational,
                                         FormulationKind::TotalLagrangian),
                       kOrders, kMaterials));
INSTANTIATE_TEST_SUITE_P(
    All, FemConsistentFormulation,
    ::testing::Combine(::testing::Values(FormulationKind::Linear,
                                         FormulationKind::ConsistentCorotational,
                                         FormulationKind::TotalLagrangian),
                       kOrders, kMaterials));

// The two co-rotational formulations differ in the tangent alone. Both forces carry the round-off
// of the rotation, ε E l² ~ 2e-16 · 5e6 · 1e-3 N = 1e-12 N, for some twenty elements at a node.
TEST(FemFormulations, BothCorotationalOnesHaveTheSameForces) {
  for (int order : {1, 2}) {
    const TetMesh mesh = bar(order);
    const Eigen::VectorXd x = deformed(mesh);
    const auto simplified = make_formulation(FormulationKind::Corotational, mesh, kSoft);
    const auto consistent = make_formulation(FormulationKind::ConsistentCorotational, mesh, kSoft);
    EXPECT_LT((evaluated(*simplified, x).f - evaluated(*consistent, x).f).cwiseAbs().maxCoeff(),
              1e-9);
  }
}

// The road of several materials, taken with twice the same one, against the fast kernel.
TEST(FemFormulations, SeveralEqualMaterialsAreOne) {
  const TetMesh mesh = bar();
  const Eigen::VectorXd x = deformed(mesh);
  Materials twice;
  twice.list = {kSoft, kSoft};
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) twice.of_element.push_back(e % 2 == 0);
  const Evaluated one = evaluated(*make_formulation(FormulationKind::Corotational, mesh, kSoft), x);
  const Evaluated two = evaluated(*make_formulation(FormulationKind::Corotational, mesh, twice), x);
  EXPECT_LT((one.f - two.f).cwiseAbs().maxCoeff(), 1e-9);
  double largest = 0.0;
  for (double value : one.K) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < one.K.size(); ++i) {
    EXPECT_NEAR(one.K[i], two.K[i], 1e-13 * largest);
  }
}

// Closed forms of St. Venant–Kirchhoff in uniaxial stretch λ without lateral strain:
// P = λ (λ_L + 2 μ) (λ² − 1)/2; of the co-rotational law: P = (λ_L + 2 μ) (λ − 1).
TEST(FemStressLaw, UniaxialStretchHasItsClosedForm) {
  const double modulus = 5e6 * 0.7 / (1.3 * 0.4);
  const double stretch = 1.25;
  const Eigen::Matrix3d R = rotation({0.3, -1.0, 2.0}).toRotationMatrix();
  const Eigen::Matrix3d F = R * Eigen::Vector3d(stretch, 1, 1).asDiagonal();
  const StVenantKirchhoffLaw green(elasticity(kSoft));
  const CorotatedLaw biot(elasticity(kSoft));
  EXPECT_NEAR((R.transpose() * green.stress(green.at(F)))(0, 0),
              stretch * modulus * (stretch * stretch - 1) / 2, 1e-14 * modulus);
  EXPECT_NEAR((R.transpose() * biot.stress(biot.at(F)))(0, 0), modulus * (stretch - 1),
              1e-14 * modulus);
}

TEST(FemStressLaw, InvertedElementsHaveFiniteDerivatives) {
  const CorotatedLaw law(elasticity(kSoft));
  for (const Eigen::Vector3d& stretch : {Eigen::Vector3d(1, 1, -1), Eigen::Vector3d(0, 0, 0),
                                         Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1, -1, 1)}) {
    const CorotatedLaw::Point point = law.at(stretch.asDiagonal());
    EXPECT_TRUE(point.inverted);
    EXPECT_TRUE(law.derivative(point, Eigen::Matrix3d::Random()).allFinite());
  }
}

}  // namespace
}  // namespace tandem::fem
