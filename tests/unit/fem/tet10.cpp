#include "fem_process/mesh/tet10.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

#include "fem_process/elements/make_formulation.h"
#include "fem_process/elements/mass.h"
#include "fem_process/matrix/node_rotations.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"
#include "tests/support/tet10_bar.h"

namespace tandem::fem {
namespace {

using namespace testing;

const Material kSoft{.young_Pa = 5e6, .poisson = 0.3, .density_kg_per_m3 = 1000.0};

constexpr FormulationKind kAll[] = {FormulationKind::Linear, FormulationKind::Corotational,
                                    FormulationKind::ConsistentCorotational,
                                    FormulationKind::TotalLagrangian};

/// Barycentric coordinates of the ten nodes.
std::vector<Eigen::Vector4d> node_coordinates() {
  std::vector<Eigen::Vector4d> L;
  for (int k = 0; k < 4; ++k) L.push_back(Eigen::Vector4d::Unit(k));
  for (const auto& edge : kTetEdges) L.push_back(0.5 * (L[edge[0]] + L[edge[1]]));
  return L;
}

TEST(FemTet10, ShapeFunctionsAreOneAtTheirNodeAndZeroAtTheOthers) {
  const std::vector<Eigen::Vector4d> L = node_coordinates();
  for (int i = 0; i < 10; ++i) {
    const Eigen::Matrix<double, 10, 1> N = tet10_shape(L[static_cast<std::size_t>(i)]);
    for (int j = 0; j < 10; ++j) EXPECT_EQ(N(j), i == j ? 1.0 : 0.0);
  }
}

// N is of degree 2: central differences are exact but for round-off, ε/δ ~ 1e-13.
TEST(FemTet10, DerivativesAgreeWithDifferences) {
  const Eigen::Vector4d L(0.1, 0.2, 0.3, 0.4);
  const double delta = 1e-3;
  const Eigen::Matrix<double, 10, 3> exact = tet10_derivatives(L);
  for (int k = 1; k < 4; ++k) {
    const Eigen::Vector4d step = delta * (Eigen::Vector4d::Unit(k) - Eigen::Vector4d::Unit(0));
    const Eigen::Matrix<double, 10, 1> differences =
        (tet10_shape(L + step) - tet10_shape(L - step)) / (2.0 * delta);
    EXPECT_LT((differences - exact.col(k - 1)).norm(), 1e-12);
  }
}

double factorial(int n) { return n < 2 ? 1.0 : n * factorial(n - 1); }

/// Largest error of a rule over the monomials of one degree, whose means over a tet are
/// 6 a! b! c! d!/(a + b + c + d + 3)!.
template <class Rule>
double error_of_degree(const Rule& rule, int degree) {
  double worst = 0.0;
  for (int a = 0; a <= degree; ++a) {
    for (int b = 0; a + b <= degree; ++b) {
      for (int c = 0; a + b + c <= degree; ++c) {
        const int d = degree - a - b - c;
        double sum = 0.0;
        for (const TetPoint& at : rule) {
          sum += at.weight * std::pow(at.L(0), a) * std::pow(at.L(1), b) * std::pow(at.L(2), c) *
                 std::pow(at.L(3), d);
        }
        const double exact =
            6.0 * factorial(a) * factorial(b) * factorial(c) * factorial(d) / factorial(degree + 3);
        worst = std::max(worst, std::abs(sum - exact));
      }
    }
  }
  return worst;
}

TEST(FemTet10, RulesAreExactToTheirDegreeAndNoFurther) {
  for (int degree = 0; degree <= 2; ++degree) {
    EXPECT_LT(error_of_degree(tet_rule_of_degree_2(), degree), 1e-15);
  }
  EXPECT_GT(error_of_degree(tet_rule_of_degree_2(), 3), 1e-4);
  for (int degree = 0; degree <= 5; ++degree) {
    EXPECT_LT(error_of_degree(tet_rule_of_degree_5(), degree), 1e-15);
  }
  EXPECT_GT(error_of_degree(tet_rule_of_degree_5(), 6), 1e-7);
}

Eigen::VectorXd forces_at(const TetMesh& mesh, FormulationKind kind,
                          const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map) {
  Eigen::VectorXd x(3 * mesh.nodes());
  for (int i = 0; i < mesh.nodes(); ++i) {
    x.segment<3>(3 * i) = map(mesh.X[static_cast<std::size_t>(i)]);
  }
  Eigen::VectorXd f;
  BlockValues K;
  make_formulation(kind, mesh, kSoft)->evaluate(x, f, K);
  return f;
}

// Patch test: a uniform deformation, large for the nonlinear formulations, leaves no force inside.
// Round-off: ε E l² · strain · 30 elements ~ 1e-13 N beside forces of E l² = 500 N.
TEST(FemTet10, UniformDeformationLeavesInnerNodesInEquilibrium) {
  Eigen::Matrix3d A;
  A << 1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.2, 0.1, 1.05;
  const TetMesh mesh = read_mesh({.file = data_file("bar.msh"), .order = 2});
  const std::vector<int> inner = inner_nodes(mesh);
  ASSERT_GT(inner.size(), 100U);
  for (FormulationKind kind : kAll) {
    const Eigen::VectorXd f =
        forces_at(mesh, kind, [&](const Eigen::Vector3d& X) { return Eigen::Vector3d(A * X); });
    for (int i : inner) EXPECT_LT(f.segment<3>(3 * i).norm(), 1e-10);
  }
}

/// Pure bending about y with curvature κ: σ_xx = E κ z alone, without volume forces.
Eigen::Vector3d bent(const Eigen::Vector3d& X, double curvature) {
  const double nu = kSoft.poisson;
  const double x = X.x();
  const double y = X.y();
  const double z = X.z();
  return X + curvature * Eigen::Vector3d(x * z, -nu * y * z, -0.5 * (x * x + nu * (z * z - y * y)));
}

// The quadratic field of pure bending is in the space of the element: equilibrium inside, and the
// energy ½ E I κ² l. Round-off: ε |K| |X| = 2e-16 · 1e6 N/m · 0.3 m. First-order tets strain more.
TEST(FemTet10, PureBendingIsExactInTheLinearFormulation) {
  const double curvature = 0.1;
  const double expected = 0.5 * 5e6 * std::pow(0.05, 4) / 12.0 * curvature * curvature * 0.5;
  for (int order : {1, 2}) {
    const TetMesh mesh = read_mesh({.file = data_file("bar.msh"), .order = order});
    Eigen::VectorXd x(3 * mesh.nodes());
    for (int i = 0; i < mesh.nodes(); ++i) {
      x.segment<3>(3 * i) = bent(mesh.X[static_cast<std::size_t>(i)], curvature);
    }
    const auto formulation = make_formulation(FormulationKind::Linear, mesh, kSoft);
    Eigen::VectorXd f;
    BlockValues K;
    formulation->evaluate(x, f, K);
    double largest = 0.0;
    for (int i : inner_nodes(mesh)) largest = std::max(largest, f.segment<3>(3 * i).norm());
    if (order == 2) {
      EXPECT_LT(largest, 1e-10);
      EXPECT_NEAR(formulation->energy(x), expected, 1e-12 * expected);
    } else {
      EXPECT_GT(formulation->energy(x), 1.5 * expected);
    }
  }
}

// A bar bent to a circle of 0.5 m · κ = 2 rad: the co-rotational element with the rotation at every
// integration point strains like the beam, ½ E I κ² l, although its ends turn by a radian each
// way. With R of the element's mean the difference of rotations within an element, κ l_e = 0.12,
// would count as strain. Tolerance: interpolating the circle by parabolas, (κ l_e)² ~ 1.4 %.
TEST(FemTet10, BendingByLargeAnglesStrainsLikeTheBeam) {
  const double curvature = 4.0;
  const double nu = kSoft.poisson;
  const TetMesh mesh = read_mesh({.file = data_file("bar.msh"), .order = 2});
  Eigen::VectorXd x(3 * mesh.nodes());
  for (int i = 0; i < mesh.nodes(); ++i) {
    const Eigen::Vector3d& X = mesh.X[static_cast<std::size_t>(i)];
    // The section of pure bending, its axis on a circle.
    const Eigen::Vector3d local =
        curvature *
        Eigen::Vector3d(0, -nu * X.y() * X.z(), -0.5 * nu * (X.z() * X.z() - X.y() * X.y()));
    const double y = X.y() + local.y();
    const double z = X.z() + local.z();
    const double angle = curvature * X.x();
    x.segment<3>(3 * i) = Eigen::Vector3d((1.0 / curvature + z) * std::sin(angle), y,
                                          (1.0 / curvature + z) * std::cos(angle));
  }
  const double expected = 0.5 * 5e6 * std::pow(0.05, 4) / 12.0 * curvature * curvature * 0.5;
  const auto formulation = make_formulation(FormulationKind::Corotational, mesh, kSoft);
  EXPECT_NEAR(formulation->energy(x), expected, 0.015 * expected);
}

// [Zienkiewicz & Taylor]: ρ V/420 times 6, 1 between corners; 32, 16, 8 between mid nodes on the
// same, neighbouring and opposite edges; −4, −6 from a corner to the edges at and away from it.
TEST(FemTet10, MassIsThatOfTheClosedForm) {
  const TetMesh mesh = read_mesh({.file = temporary_file("mass.inp",
                                                         "*NODE\n1, 0, 0, 0\n2, 2, 0, 0\n3, 0, 3, "
                                                         "0\n4, 1, 1, 4\n*ELEMENT, TYPE=C3D4\n"
                                                         "1, 1, 2, 3, 4\n"),
                                  .order = 2});
  const BlockPattern pattern = pattern_of(mesh);
  const double unit = 1000.0 * 4.0 / 420.0;  // V = 2 · 3 · 4/6
  const std::vector<double> M = mass_matrix(mesh, pattern, kSoft, MassKind::Consistent);
  const std::vector<int> nodes = mesh.element(0);
  const auto expected = [](std::size_t i, std::size_t j) {
    if (i > j) std::swap(i, j);
    if (j < 4) return i == j ? 6.0 : 1.0;
    const auto& b = kTetEdges[j - 4];
    if (i < 4) return b[0] == i || b[1] == i ? -4.0 : -6.0;
    const auto& a = kTetEdges[i - 4];
    const int common = (a[0] == b[0]) + (a[0] == b[1]) + (a[1] == b[0]) + (a[1] == b[1]);
    return common == 2 ? 32.0 : common == 1 ? 16.0 : 8.0;
  };
  for (std::size_t i = 0; i < 10; ++i) {
    for (std::size_t j = 0; j < 10; ++j) {
      EXPECT_NEAR(M[static_cast<std::size_t>(pattern.find(nodes[i], nodes[j]))],
                  unit * expected(i, j), 1e-12 * unit)
          << i << ", " << j;
    }
  }
  const std::vector<double> lumped = mass_matrix(mesh, pattern, kSoft, MassKind::Lumped);
  for (std::size_t i = 0; i < 10; ++i) {
    for (std::size_t j = 0; j < 10; ++j) {
      const double share = i != j ? 0.0 : i < 4 ? 1.0 / 36.0 : 4.0 / 27.0;
      EXPECT_NEAR(lumped[static_cast<std::size_t>(pattern.find(nodes[i], nodes[j]))],
                  4000.0 * share, 1e-10);
    }
  }
}

TEST(FemTet10, BothKindsHaveTheMassOfTheVolumeAndLumpedOnesArePositive) {
  const double expected = 1000.0 * 0.5 * 0.05 * 0.05;
  const TetMesh mesh = curved_bar();  // curved inside, its outside is the box
  const BlockPattern pattern = pattern_of(mesh);
  for (MassKind kind : {MassKind::Lumped, MassKind::Consistent}) {
    double sum = 0.0;
    for (double m : mass_matrix(mesh, pattern, kSoft, kind)) sum += m;
    EXPECT_NEAR(sum, expected, 1e-12 * expected);
  }
  double volume_found = 0.0;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) volume_found += volume(mesh, e);
  EXPECT_NEAR(1000.0 * volume_found, expected, 1e-12 * expected);
  const std::vector<double> lumped = mass_matrix(mesh, pattern, kSoft, MassKind::Lumped);
  for (int i = 0; i < mesh.nodes(); ++i) {
    EXPECT_GT(lumped[static_cast<std::size_t>(pattern.find(i, i))], 0.0);
  }
}

// In single precision: 6e-8 for each of nine numbers below 1.
TEST(FemTet10, NodeRotationsOfARigidlyTurnedBodyAreItsRotation) {
  Params params = bar_with_two_ports();
  params.mesh.order = 2;
  const Model model(params);
  const NodeRotations rotations(model.mesh, model.pattern(), model.free);
  const Eigen::Matrix3d R = rotation({0.7, -2.0, 1.1}).toRotationMatrix();
  Eigen::VectorXd x = model.reference();
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    x.segment<3>(i) = R * x.segment<3>(i) + Eigen::Vector3d(3, -1, 2);
  }
  std::vector<NodeRotation> nodes;
  ThreadTeam alone;
  rotations.at(x, nodes, alone);
  ASSERT_EQ(nodes.size(), model.free.size());
  for (const NodeRotation& node : nodes) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(node.row[i][j], R(i, j), 1.2e-7);
    }
  }
}

// Free fall under gravity strains nothing, with either mass: every node is where g t²/2 has it (the
// rule is exact for constant accelerations).
TEST(FemTet10, FallsFreelyWithoutStrain) {
  for (MassKind mass : {MassKind::Lumped, MassKind::Consistent}) {
    Params params = bar_with_two_ports();
    params.mesh.order = 2;
    params.ports.clear();
    params.mass = mass;
    params.integrator = {.kind = IntegratorKind::Hht, .hht_alpha = 0.0};
    params.gravity_m_per_s2 = {1.0, -2.0, -9.81};
    FlexibleBody body(params);
    body.initialize({});
    for (int k = 0; k < 10; ++k) {
      ASSERT_EQ(body.advance(request({}, {}, SimTime(1'000'000))).outcome, Outcome::Done);
    }
    const Eigen::VectorXd u = body.state().x - body.model().reference();
    const Eigen::Vector3d expected = 0.5 * 0.01 * 0.01 * params.gravity_m_per_s2;
    for (Eigen::Index i = 0; i < u.size(); i += 3) {
      EXPECT_LT((u.segment<3>(i) - expected).norm(), 1e-13);
    }
  }
}

}  // namespace
}  // namespace tandem::fem
