#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "fem_process/make_formulation.h"
#include "fem_process/polar.h"
#include "fem_process/stress_law.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

const Material kSoft{.young_Pa = 5e6, .poisson = 0.3, .density_kg_per_m3 = 1000.0};

TetMesh bar() { return read_mesh({.file = data_file("bar.msh")}); }

Eigen::VectorXd noise(Eigen::Index size, double amplitude, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  return Eigen::VectorXd::NullaryExpr(size, [&] { return uniform(random); });
}

/// Turned by about 2 rad and strained by about 10 %.
Eigen::VectorXd deformed(const TetMesh& mesh) {
  Eigen::VectorXd x = noise(3 * mesh.nodes(), 2e-3, 7);
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

class FemFormulation : public ::testing::TestWithParam<FormulationKind> {
 protected:
  TetMesh mesh = bar();
  std::unique_ptr<const Formulation> formulation = make_formulation(GetParam(), mesh, kSoft);
};
class FemConsistentFormulation : public FemFormulation {};

// Central differences with 1e-6 m of edges of 0.03 m: truncation (1e-6/0.03)² ~ 1e-9; round-off
// ε E_total/δ ~ 1e-16 · 10 J/1e-6 m = 1e-9 N beside forces of 100 N.
TEST_P(FemFormulation, ForceIsTheGradientOfTheEnergy) {
  Eigen::VectorXd x = deformed(mesh);
  const Eigen::VectorXd f = evaluated(*formulation, x).f;
  const double delta = 1e-6;
  for (Eigen::Index i = 0; i < x.size(); i += 7) {
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
  const auto linear = make_formulation(FormulationKind::Linear, mesh, kSoft);
  const BlockValues expected = evaluated(*linear, X).K;
  const Evaluated found = evaluated(*formulation, X);
  double largest = 0.0;
  for (double value : expected) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(found.K[i], expected[i], 64 * 2.3e-16 * largest);
  }
  EXPECT_LT(found.f.cwiseAbs().maxCoeff(), 1e-16 * largest);
}

TEST_P(FemFormulation, VonMisesOfUniaxialTensionIsTheStress) {
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

INSTANTIATE_TEST_SUITE_P(All, FemFormulation,
                         ::testing::Values(FormulationKind::Linear, FormulationKind::Corotational,
                                           FormulationKind::ConsistentCorotational,
                                           FormulationKind::TotalLagrangian));
INSTANTIATE_TEST_SUITE_P(All, FemConsistentFormulation,
                         ::testing::Values(FormulationKind::Linear,
                                           FormulationKind::ConsistentCorotational,
                                           FormulationKind::TotalLagrangian));

// The two co-rotational formulations differ in the tangent alone. Both forces carry the round-off
// of the rotation, ε E l² ~ 2e-16 · 5e6 · 1e-3 N = 1e-12 N, for some twenty elements at a node.
TEST(FemFormulations, BothCorotationalOnesHaveTheSameForces) {
  const TetMesh mesh = bar();
  const Eigen::VectorXd x = deformed(mesh);
  const auto simplified = make_formulation(FormulationKind::Corotational, mesh, kSoft);
  const auto consistent = make_formulation(FormulationKind::ConsistentCorotational, mesh, kSoft);
  EXPECT_LT((evaluated(*simplified, x).f - evaluated(*consistent, x).f).cwiseAbs().maxCoeff(),
            1e-9);
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
