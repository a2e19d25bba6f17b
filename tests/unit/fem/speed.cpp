#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "fem_process/kernels/simd.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/node_vectors.h"
#include "fem_process/sides/step_benchmark.h"
#include "fem_process/solvers/elimination_parts.h"
#include "fem_process/solvers/factor_panels.h"
#include "fem_process/solvers/rest_factor.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

TEST(ThreadTeam, EveryPartOfEveryLoopIsWorkedOnceForAnyNumberOfThreads) {
  for (int threads = 1; threads <= 4; ++threads) {
    ThreadTeam team(threads);
    EXPECT_EQ(team.threads(), threads);
    for (int parts : {0, 1, 2, 3, 17, 400}) {
      for (int repetition = 0; repetition < 20; ++repetition) {
        std::vector<std::atomic<int>> count(static_cast<std::size_t>(parts));
        team.run(parts, [&](int k) { ++count[static_cast<std::size_t>(k)]; });
        for (const std::atomic<int>& once : count) ASSERT_EQ(once.load(), 1);
      }
    }
  }
}

TEST(ThreadTeam, RangesCoverTheWholeInPiecesOfTheGrain) {
  ThreadTeam team(2);
  std::vector<int> count(1000, 0);
  team.run_ranges(count.size(), 64, [&](std::size_t begin, std::size_t end) {
    EXPECT_EQ(begin % 64, 0U);
    EXPECT_LE(end - begin, 64U);
    for (std::size_t i = begin; i < end; ++i) ++count[i];
  });
  for (int once : count) EXPECT_EQ(once, 1);
}

/// Positions after 40 steps of the swung lug.
Eigen::VectorXd swing(const SolverParams& solver, int threads, int order = 1) {
  Params params =
      benchmark_params(benchmark_case("soft"), data_file("lug_1k.msh"), "clamp", "eye", solver);
  params.threads = threads;
  params.mesh.order = order;
  return run_benchmark(params, 40).kept.back();
}

constexpr SolverParams kWarped{.kind = SolverKind::Pcg, .tolerance = 1e-6};
constexpr SolverParams kBlockJacobi{.kind = SolverKind::Pcg,
                                    .tolerance = 1e-6,
                                    .preconditioner = PreconditionerKind::BlockJacobi,
                                    .initial_guess = InitialGuess::Previous};

TEST(SameBits, ForAnyNumberOfThreads) {
  for (const SolverParams& solver :
       {kWarped, kBlockJacobi, SolverParams{.kind = SolverKind::Cholmod}}) {
    const Eigen::VectorXd alone = swing(solver, 1);
    EXPECT_EQ(swing(solver, 2), alone);
    EXPECT_EQ(swing(solver, 3), alone);
  }
}

TEST(SameBits, OfSecondOrderForAnyNumberOfThreadsAndEveryRepetition) {
  const Eigen::VectorXd alone = swing(kWarped, 1, 2);
  EXPECT_EQ(swing(kWarped, 2, 2), alone);
  EXPECT_EQ(swing(kWarped, 2, 2), alone);
}

TEST(SameBits, WithAndWithoutVectorInstructions) {
  const Eigen::VectorXd best = swing(kWarped, 1);
  for (const VectorUnit unit : {VectorUnit::Avx2, VectorUnit::Plain}) {
    limit_vector_unit(unit);
    EXPECT_EQ(swing(kWarped, 1), best);
  }
  limit_vector_unit(VectorUnit::Avx512);
}

Eigen::VectorXf waves_f(int n) {
  Eigen::VectorXf x(n);
  for (int i = 0; i < n; ++i) x[i] = std::sin(1.0F + 0.7F * static_cast<float>(i));
  return x;
}

// A number is rounded to half of 1/32766 of its column's largest, its word's other half may add
// one: 4.6e-5 of the largest in each term, and single precision in the sums.
TEST(FactorPanels, ProductsAreThoseOfTheMatrixToSixteenBits) {
  FactorPanels panels;
  for (const auto& [rows, columns] :
       {std::pair{3, 3}, {15, 6}, {40, 9}, {130, 33}, {300, 192}, {450, 450}}) {
    Eigen::MatrixXd P(rows, columns);
    for (int i = 0; i < rows; ++i) {
      for (int k = 0; k < columns; ++k) {
        P(i, k) = i < k ? 0.0 : std::exp(3.0 * std::sin(0.1 * k)) * std::cos(1.0 + 3 * i + 7 * k);
      }
    }
    const FactorPanels::Panel panel = panels.add(P);
    const Eigen::VectorXd most = P.cwiseAbs().colwise().maxCoeff();
    const auto padded = static_cast<std::size_t>(panel.tiles() * FactorPanels::kTile);

    const Eigen::VectorXf x = waves_f(columns);
    std::vector<float> scaled(static_cast<std::size_t>(columns) + 1);
    std::vector<float> out(padded);
    panels.scale(panel, x.data(), scaled.data());
    panels.multiply(panel, scaled.data(), 0, panel.tiles(), out.data());
    const Eigen::VectorXd product = P * x.cast<double>();
    const double bound = 5e-5 * most.dot(x.cwiseAbs().cast<double>());
    for (int i = 0; i < rows; ++i) {
      EXPECT_NEAR(out[static_cast<std::size_t>(i)], product[i], bound) << rows << " × " << columns;
    }

    const Eigen::VectorXf y = waves_f(rows);
    std::vector<float> in(padded, 0.0F);
    std::copy(y.begin(), y.end(), in.begin());
    panels.multiply_transposed(panel, in.data(), 0, panel.pairs(), out.data());
    const Eigen::VectorXd transposed = P.transpose() * y.cast<double>();
    for (int k = 0; k < columns; ++k) {
      EXPECT_NEAR(out[static_cast<std::size_t>(k)], transposed[k],
                  most[k] * (5e-5 * y.cwiseAbs().sum()))
          << rows << " × " << columns;
    }
  }
}

struct InteriorSystem {
  Model model;
  BlockValues A;
};

/// The free nodes' stiffness at the reference positions.
InteriorSystem interior_system(Params params) {
  InteriorSystem system{Model(std::move(params)), {}};
  Eigen::VectorXd f_int;
  BlockValues K;
  const Model& model = system.model;
  model.formulation->evaluate(model.reference(), f_int, K);
  system.A.resize(9 * model.interior.pattern.blocks());
  for (std::size_t b = 0; b < model.interior.source.size(); ++b) {
    block(system.A, static_cast<int>(b)) = block(K, model.interior.source[b]);
  }
  return system;
}

Eigen::VectorXd waves(Eigen::Index n) {
  Eigen::VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = std::sin(1.0 + 0.7 * static_cast<double>(i));
  return x;
}

// Entries of the panels are rounded to 2⁻¹⁶ of their column's largest. L⁻¹ of a matrix of condition
// number κ (about 1e3 here) carries that to a relative error of 2⁻¹⁶ √κ in the energy norm, times a
// modest constant of the sums: conjugate gradients gain more than a digit and a half a step.
TEST(RestFactor, SolvesToAPercentInTheNormOfEnergy) {
  const InteriorSystem system = interior_system(bar_with_two_ports());
  const BlockPattern& pattern = system.model.interior.pattern;
  const RestFactor factor(pattern, system.A);
  const Eigen::VectorXd expected = waves(3 * pattern.rows());
  const auto energy = [&](const Eigen::VectorXd& v) {
    return std::sqrt(v.dot(multiply(pattern, system.A, v)));
  };
  ThreadTeam alone;
  // 1e-60: beyond the range of single precision.
  for (const double scale : {1.0, 1e-60}) {
    const Eigen::VectorXd right = scale * multiply(pattern, system.A, expected);
    std::vector<Padded> r;
    pad(right, r);
    std::vector<Padded> z(r.size());
    RestFactor::Scratch scratch;
    const double product = factor.solve(r, right.norm(), {}, z, scratch, alone);
    Eigen::VectorXd solution;
    unpad(z, solution);
    EXPECT_LT(energy(solution / scale - expected), 1e-2 * energy(expected));
    EXPECT_NEAR(product, right.dot(solution), 1e-12 * std::abs(product));
  }
}

// No row of a part belongs to another part: they can be eliminated at the same time.
TEST(EliminationParts, AreIndependentAndHoldEverySupernodeOnce) {
  const InteriorSystem system = interior_system(
      benchmark_params(benchmark_case("soft"), data_file("lug_1k.msh"), "clamp", "eye", {}));
  CholmodSolver solver(system.model.interior.pattern);
  ASSERT_EQ(solver.factorize(system.A).outcome, Outcome::Done);
  const SupernodalFactor factor = solver.factor();
  const EliminationParts cut_parts = cut(factor);
  ASSERT_GE(cut_parts.parts.size(), 4U);
  std::vector<int> owner(factor.permutation.size(), -2);
  const auto own = [&](const std::vector<int>& supernodes, int part) {
    for (int s : supernodes) {
      const auto at = static_cast<std::size_t>(s);
      for (int c = factor.first_column[at]; c < factor.first_column[at + 1]; ++c) {
        EXPECT_EQ(std::exchange(owner[static_cast<std::size_t>(c)], part), -2);
      }
    }
  };
  own(cut_parts.top, -1);
  for (std::size_t p = 0; p < cut_parts.parts.size(); ++p) {
    own(cut_parts.parts[p], static_cast<int>(p));
  }
  for (std::size_t s = 0; s + 1 < factor.first_column.size(); ++s) {
    const int part = owner[static_cast<std::size_t>(factor.first_column[s])];
    for (int k = factor.row_start[s]; k < factor.row_start[s + 1]; ++k) {
      const int above = owner[static_cast<std::size_t>(factor.row[static_cast<std::size_t>(k)])];
      EXPECT_TRUE(above == part || above == -1);
    }
  }
}

}  // namespace
}  // namespace tandem::fem
