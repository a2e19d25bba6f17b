#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "fem_process/matrix/lattice.h"
#include "fem_process/matrix/node_vectors.h"
#include "fem_process/sides/step_benchmark.h"
#include "fem_process/solvers/gauss_seidel.h"
#include "fem_process/solvers/pcg_solver.h"
#include "fem_process/solvers/rest_multigrid.h"
#include "tests/support/fem_support.h"
#include "tests/support/lug_system.h"

// Multigrid as a preconditioner: order in space, lattices, sweeps, the cycle, steps solved with it.
namespace tandem::fem {
namespace {

using namespace testing;

Eigen::VectorXd ripples(Eigen::Index n, double phase) {
  Eigen::VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = std::sin(phase + 0.7 * static_cast<double>(i));
  return x;
}

TEST(NearOrder, HoldsEveryPositionOnceAndKeepsNeighboursTogether) {
  std::vector<Eigen::Vector3d> X;
  for (int i = 0; i < 512; ++i) {
    const int k = 197 * i % 512;  // an order that jumps
    X.emplace_back(k % 8, k / 8 % 8, k / 64);
  }
  const std::vector<int> order = near_order(X);
  std::vector<int> count(X.size(), 0);
  for (int i : order) ++count[static_cast<std::size_t>(i)];
  EXPECT_EQ(count, std::vector<int>(X.size(), 1));
  // Eight that follow each other, from a multiple of eight on, are a cube of side one.
  for (std::size_t first = 0; first < order.size(); first += 8) {
    for (std::size_t k = first; k < first + 8; ++k) {
      const Eigen::Vector3d apart =
          X[static_cast<std::size_t>(order[k])] - X[static_cast<std::size_t>(order[first])];
      EXPECT_LE(apart.cwiseAbs().maxCoeff(), 1.0);
    }
  }
}

// Trilinear functions hold the linear ones: Σ w x_lattice = x, to round-off of the positions.
TEST(Lattice, HoldsLinearDisplacements) {
  const LugSystem lug;
  const Lattice lattice(lug.X, 0.02);
  ASSERT_LT(lattice.positions().size(), lug.X.size() / 2);
  for (std::size_t i = 0; i < lug.X.size(); ++i) {
    const Lattice::Corners& corners = lattice.corners()[i];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (std::size_t c = 0; c < 8; ++c) {
      sum += corners.weight[c] * lattice.positions()[static_cast<std::size_t>(corners.node[c])];
      weights += corners.weight[c];
    }
    // Corners of less than 1e-9 are left out, at 0.02 m.
    EXPECT_LT((sum - lug.X[i]).norm(), 1e-9);
    EXPECT_NEAR(weights, 1.0, 1e-8);
  }
}

// uᵀ (Pᵀ A P) u = (P u)ᵀ A (P u), the diagonal's 1e-6 apart.
TEST(Lattice, ProjectsTheEnergy) {
  const LugSystem lug;
  const Lattice lattice(lug.X, 0.02);
  BlockPattern pattern;
  BlockValues A;
  lattice.project(lug.pattern(), lug.A, pattern, A);
  const Eigen::VectorXd u = ripples(3 * pattern.rows(), 1.0);
  Eigen::VectorXd Pu = Eigen::VectorXd::Zero(3 * lug.pattern().rows());
  for (std::size_t i = 0; i < lug.X.size(); ++i) {
    const Lattice::Corners& corners = lattice.corners()[i];
    for (std::size_t c = 0; c < 8; ++c) {
      Pu.segment<3>(3 * static_cast<Eigen::Index>(i)) +=
          corners.weight[c] * u.segment<3>(3 * corners.node[c]);
    }
  }
  double diagonal = 0.0;
  for (int a = 0; a < pattern.rows(); ++a) {
    const Eigen::Vector3d u_a = u.segment<3>(3 * a);
    diagonal += u_a.dot(block(A, pattern.find(a, a)) * u_a);
  }
  const double energy = u.dot(multiply(pattern, A, u)) - 1e-6 / (1.0 + 1e-6) * diagonal;
  EXPECT_NEAR(energy, Pu.dot(multiply(lug.pattern(), lug.A, Pu)), 1e-11 * diagonal);
}

std::vector<Padded4> padded4(const Eigen::VectorXd& x) {
  std::vector<Padded4> out;
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    out.push_back({{static_cast<float>(x[i]), static_cast<float>(x[i + 1]),
                    static_cast<float>(x[i + 2]), 0.0F}});
  }
  return out;
}

// A forward sweep leaves r − A x, a backward one solves each row with the others' last numbers:
// both as the matrix itself says, in the sweeps' order and scale. Single precision: 6e-8 for each
// of some 40 terms.
TEST(GaussSeidel, LeavesTheResidualAndSolvesRowByRow) {
  const LugSystem lug;
  const BlockPattern& pattern = lug.pattern();
  const GaussSeidel sweeps(pattern, lug.A, near_order(lug.X));
  const std::size_t n = sweeps.nodes();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(3 * pattern.rows(), 3 * pattern.rows());
  for (std::size_t p = 0; p < n; ++p) {
    for (std::size_t q = 0; q < n; ++q) {
      const int b = pattern.find(sweeps.order()[p], sweeps.order()[q]);
      const auto row = static_cast<std::size_t>(sweeps.order()[p]);
      if (b >= pattern.row_start[row + 1] ||
          pattern.column[static_cast<std::size_t>(b)] != sweeps.order()[q]) {
        continue;
      }
      A.block<3, 3>(3 * static_cast<Eigen::Index>(p), 3 * static_cast<Eigen::Index>(q)) =
          block(lug.A, b) / (sweeps.root()[p] * sweeps.root()[q]);
    }
  }
  const Eigen::VectorXd right = ripples(A.rows(), 1.0);
  const std::vector<Padded4> r = padded4(right);
  std::vector<Padded4> x(n);
  std::vector<Padded4> left(n);
  ThreadTeam team(2);
  const auto whole = [](const std::vector<Padded4>& from) {
    Eigen::VectorXd v(3 * static_cast<Eigen::Index>(from.size()));
    for (std::size_t i = 0; i < from.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        v[static_cast<Eigen::Index>(3 * i + k)] = static_cast<double>(from[i].at[k]);
      }
      EXPECT_EQ(from[i].at[3], 0.0F);
    }
    return v;
  };
  sweeps.forward(r.data(), x.data(), team);
  sweeps.residual(x.data(), left.data(), team);
  const double round_off = 3e-6 * std::max(1.0, whole(x).cwiseAbs().maxCoeff());
  EXPECT_LT((whole(left) - (right - A * whole(x))).cwiseAbs().maxCoeff(), round_off);
  Eigen::VectorXd expected = whole(x);
  for (Eigen::Index i = expected.size() - 3; i >= 0; i -= 3) {
    const Eigen::Matrix3d D = A.block<3, 3>(i, i);
    const Eigen::Vector3d rest =
        right.segment<3>(i) - A.middleRows<3>(i) * expected + D * expected.segment<3>(i);
    expected.segment<3>(i) = D.inverse() * rest;
  }
  sweeps.backward(r.data(), x.data(), team);
  EXPECT_LT((whole(x) - expected).cwiseAbs().maxCoeff(), round_off);
}

Eigen::VectorXd apply(const RestInverse& inverse, const Eigen::VectorXd& right, double norm,
                      int threads) {
  std::vector<Padded> r;
  pad(right, r);
  std::vector<Padded> z(r.size());
  RestInverse::Scratch scratch;
  ThreadTeam team(threads);
  const double product = inverse.solve(r, norm, {}, z, scratch, team);
  Eigen::VectorXd solution;
  unpad(z, solution);
  EXPECT_NEAR(product, right.dot(solution), 1e-12 * std::abs(product));
  return solution;
}

// Two levels and more. Symmetric as single precision and the coarsest factor's 16 bits allow: 1e-4
// of the products' size. No eigenvalue of B A is above 1 (a cycle takes no error up), to the same
// round-off. Their ratio κ bounds conjugate gradients, which gain (√κ − 1)/(√κ + 1) a step: a digit
// in three steps at worst is κ ≤ 7.4. (The lug's is 3.7 with two levels and with three.)
TEST(RestMultigrid, IsSymmetricPositiveDefiniteAndNearTheInverse) {
  const LugSystem lug;
  for (const std::size_t factorised : {std::size_t{5000}, std::size_t{20}}) {
    const RestMultigrid inverse(lug.pattern(), lug.A, lug.X, factorised);
    EXPECT_EQ(inverse.levels(), factorised == 20 ? 2U : 1U);
    const Eigen::Index n = 3 * lug.pattern().rows();
    Eigen::MatrixXd B(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      B.col(k) = apply(inverse, Eigen::VectorXd::Unit(n, k), 1.0, 1);
    }
    EXPECT_LT((B - B.transpose()).norm(), 1e-4 * B.norm());
    Eigen::MatrixXd A(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      A.col(k) = multiply(lug.pattern(), lug.A, Eigen::VectorXd::Unit(n, k));
    }
    const Eigen::MatrixXd L = A.llt().matrixL();
    const Eigen::MatrixXd LBL = L.transpose() * (0.5 * (B + B.transpose())) * L;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(LBL, Eigen::EigenvaluesOnly);
    EXPECT_LT(spectrum.eigenvalues().maxCoeff(), 1.01);
    EXPECT_GT(spectrum.eigenvalues().minCoeff(), spectrum.eigenvalues().maxCoeff() / 7.4);
  }
}

TEST(RestMultigrid, GivesTheSameBitsForAnyThreadsAndVectorInstructions) {
  const LugSystem lug;
  const RestMultigrid inverse(lug.pattern(), lug.A, lug.X, 20);
  const Eigen::VectorXd right = ripples(3 * lug.pattern().rows(), 2.0);
  const Eigen::VectorXd alone = apply(inverse, right, right.norm(), 1);
  EXPECT_EQ(apply(inverse, right, right.norm(), 2), alone);
  EXPECT_EQ(apply(inverse, right, right.norm(), 3), alone);
  for (const VectorUnit unit : {VectorUnit::Avx2, VectorUnit::Plain}) {
    limit_vector_unit(unit);
    EXPECT_EQ(apply(inverse, right, right.norm(), 1), alone);
  }
  limit_vector_unit(VectorUnit::Avx512);
}

// Columns side by side end at the tolerance like one alone.
TEST(RestMultigrid, SolvesSeveralColumns) {
  const LugSystem lug;
  const RestMultigrid rest(lug.pattern(), lug.A, lug.X);
  const double tolerance = 1e-8;
  PcgSolver solver({.kind = SolverKind::Pcg, .tolerance = tolerance}, lug.pattern(), &rest,
                   nullptr);
  ASSERT_EQ(solver.factorize(lug.A).outcome, Outcome::Done);
  Eigen::MatrixXd b(3 * lug.pattern().rows(), 6);
  for (Eigen::Index c = 0; c < 6; ++c) b.col(c) = ripples(b.rows(), static_cast<double>(c));
  Eigen::MatrixXd x = b;
  const Eigen::VectorXd norms = b.colwise().norm();
  ASSERT_EQ(solver.solve(x, norms).outcome, Outcome::Done);
  for (Eigen::Index c = 0; c < 6; ++c) {
    const Eigen::VectorXd r = b.col(c) - multiply(lug.pattern(), lug.A, x.col(c));
    EXPECT_LE(r.norm(), 1.001 * tolerance * norms[c]);
  }
}

// The swung lug turns by half a radian: the same positions as with the factor to what both leave of
// the right-hand sides, in at most three times its iterations (2.8 and 6.6 of 20 steps).
TEST(RestMultigrid, StepsTheLugLikeTheFactor) {
  const auto run = [](PreconditionerKind kind, int threads) {
    Params params =
        benchmark_params(benchmark_case("soft"), data_file("lug_1k.msh"), "clamp", "eye",
                         {.kind = SolverKind::Pcg, .tolerance = 1e-9, .preconditioner = kind});
    params.threads = threads;
    return run_benchmark(params, 40);
  };
  const StepBenchmark factor = run(PreconditionerKind::WarpedRestFactor, 1);
  const StepBenchmark cycle = run(PreconditionerKind::WarpedRestMultigrid, 1);
  EXPECT_LT(benchmark_error(cycle, factor), 1e-8);
  EXPECT_LT(cycle.iterations_mean, 3.0 * factor.iterations_mean);
  EXPECT_EQ(run(PreconditionerKind::WarpedRestMultigrid, 2).kept.back(), cycle.kept.back());
}

}  // namespace
}  // namespace tandem::fem
