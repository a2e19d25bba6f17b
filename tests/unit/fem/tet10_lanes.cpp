#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "fem_process/elements/corotational_tet10.h"
#include "fem_process/kernels/simd.h"
#include "tests/support/fem_support.h"
#include "tests/support/tet10_bar.h"

namespace tandem::fem {
namespace {

using namespace testing;

const Material kRubber{.young_Pa = 5e6, .poisson = 0.3, .density_kg_per_m3 = 1000.0};

/// The curved bar turned by 2 rad and strained by some 10 %.
Eigen::VectorXd turned_and_strained(const TetMesh& mesh) {
  const Eigen::Matrix3d R = rotation({0.7, -1.5, 1.1}).toRotationMatrix();
  Eigen::VectorXd x(3 * mesh.nodes());
  for (int i = 0; i < mesh.nodes(); ++i) {
    const Eigen::Vector3d& X = mesh.X[static_cast<std::size_t>(i)];
    const Eigen::Vector3d u(0.1 * X.x() * X.y() / 0.05, 0.1 * X.x() * X.x(), 0.1 * X.z());
    x.segment<3>(3 * i) = R * (X + u) + Eigen::Vector3d(3, -1, 2);
  }
  return x;
}

/// Draws a node through the opposite face of an element: those around it are inverted.
void fold(const TetMesh& mesh, Eigen::VectorXd& x) {
  const Tet& tet = mesh.tets[100];
  const auto at = [&](std::size_t k) { return x.segment<3>(3 * tet[k]); };
  at(0) += 2.0 * ((at(1) + at(2) + at(3)) / 3.0 - at(0));
}

/// Of about the size of an element, the same each time.
Eigen::VectorXd waves(Eigen::Index n, double phase) {
  Eigen::VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = 0.01 * std::sin(phase + 0.7 * static_cast<double>(i));
  return x;
}

Eigen::MatrixXd five_directions(Eigen::Index n) {
  Eigen::MatrixXd dx(n, 5);
  for (Eigen::Index c = 0; c < 5; ++c) dx.col(c) = waves(n, 1.0 + static_cast<double>(c));
  return dx;
}

struct Evaluation {
  Eigen::VectorXd f;
  BlockValues K;
  Eigen::MatrixXd changes;
  double energy = 0.0;
  int inverted = 0;
};
Evaluation evaluate(const Formulation& formulation, const Eigen::VectorXd& x) {
  Evaluation result;
  result.inverted = formulation.evaluate(x, result.f, result.K);
  result.changes = formulation.derivatives(x, five_directions(x.size()));
  result.energy = formulation.energy(x);
  return result;
}
Eigen::Map<const Eigen::VectorXd> flat(const BlockValues& K) {
  return {K.data(), static_cast<Eigen::Index>(K.size())};
}

// Sums of some 1e3 terms in another order, at strains of 0.1: ε 1e3/0.1 ~ 1e-12 at worst; at
// positions some ten elements' lengths from the origin. 369 elements: the last batch is not full.
TEST(FemTet10Lanes, GiveForcesAndStiffnessOfTheElementMatrices) {
  const TetMesh mesh = curved_bar();
  const SimplifiedCorotational<10> expected(mesh, kRubber);
  const CorotationalTet10 lanes(mesh, kRubber);
  Eigen::VectorXd x = turned_and_strained(mesh);
  for (const int folded : {0, 1}) {
    if (folded == 1) fold(mesh, x);
    const Evaluation a = evaluate(expected, x);
    const Evaluation b = evaluate(lanes, x);
    EXPECT_EQ(b.inverted, a.inverted);
    EXPECT_EQ(a.inverted > 0, folded == 1);
    EXPECT_LT((b.f - a.f).norm(), 1e-12 * a.f.norm());
    EXPECT_LT((flat(b.K) - flat(a.K)).norm(), 1e-12 * flat(a.K).norm());
  }
}

// The bound is that of the forces. Five directions: of the second group of four only one is there.
TEST(FemTet10Lanes, GiveDerivativesAndEnergyOfTheLaw) {
  const TetMesh mesh = curved_bar();
  const SimplifiedCorotational<10> expected(mesh, kRubber);
  const CorotationalTet10 lanes(mesh, kRubber);
  Eigen::VectorXd x = turned_and_strained(mesh);
  const Eigen::VectorXd y = waves(x.size(), 0.3);
  const Eigen::MatrixXd dx = five_directions(x.size());
  for (const int folded : {0, 1}) {
    if (folded == 1) fold(mesh, x);
    EXPECT_NEAR(lanes.energy(x), expected.energy(x), 1e-12 * expected.energy(x));
    const Eigen::VectorXd with_y = expected.derivative(x, y, dx.col(0));
    EXPECT_LT((lanes.derivative(x, y, dx.col(0)) - with_y).norm(), 1e-12 * with_y.norm());
    const Eigen::MatrixXd all = expected.derivatives(x, dx);
    EXPECT_LT((lanes.derivatives(x, dx) - all).norm(), 1e-12 * all.norm());
  }
}

TEST(FemTet10Lanes, GiveASymmetricStiffness) {
  const TetMesh mesh = curved_bar();
  const CorotationalTet10 lanes(mesh, kRubber);
  const BlockPattern& pattern = lanes.pattern();
  const Evaluation found = evaluate(lanes, turned_and_strained(mesh));
  for (int i = 0; i < pattern.rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
      const int j = pattern.column[static_cast<std::size_t>(b)];
      ASSERT_EQ(block(found.K, b), block(found.K, pattern.find(j, i)).transpose());
    }
  }
}

TEST(FemTet10Lanes, GiveTheSameBitsWithAnyThreadsAndInstructions) {
  const TetMesh mesh = curved_bar();
  const Eigen::VectorXd x = turned_and_strained(mesh);
  const Evaluation alone = evaluate(CorotationalTet10(mesh, kRubber), x);
  const auto expect_same = [&](const Evaluation& other) {
    EXPECT_EQ(other.f, alone.f);
    EXPECT_EQ(other.K, alone.K);
    EXPECT_EQ(other.changes, alone.changes);
    EXPECT_EQ(other.energy, alone.energy);
  };
  for (const int threads : {1, 2, 3}) {
    ThreadTeam team(threads);
    const CorotationalTet10 shared(mesh, kRubber, &team);
    for (int repetition = 0; repetition < 3; ++repetition) expect_same(evaluate(shared, x));
  }
  for (const VectorUnit unit : {VectorUnit::Avx2, VectorUnit::Plain}) {
    limit_vector_unit(unit);
    expect_same(evaluate(CorotationalTet10(mesh, kRubber), x));
  }
  limit_vector_unit(VectorUnit::Avx512);
}

}  // namespace
}  // namespace tandem::fem
