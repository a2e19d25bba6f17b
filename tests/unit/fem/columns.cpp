#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "fem_process/matrix/node_vectors.h"
#include "fem_process/sides/flexible_body.h"
#include "fem_process/solvers/cholmod_solver.h"
#include "fem_process/solvers/factor_panels.h"
#include "fem_process/solvers/pcg_solver.h"
#include "fem_process/solvers/rest_factor.h"
#include "tests/support/fem_support.h"
#include "tests/support/lug_system.h"

// Several right-hand sides side by side: factor panels, the rest factor, PCG, the interface
// Jacobian.
namespace tandem::fem {
namespace {

using namespace testing;

Eigen::MatrixXd waves(Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd x(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    for (Eigen::Index i = 0; i < rows; ++i) {
      x(i, c) = std::sin(1.0 + 0.7 * static_cast<double>(i) + 2.3 * static_cast<double>(c));
    }
  }
  return x;
}

// Both products of each vector are sums of the same terms, in single precision: 2⁻²⁴ times the
// number of terms, relative to the sum of their sizes; 1e-5 for 450 of them.
TEST(FactorPanelsOfEight, ProductsAreThoseOfEachVectorAlone) {
  FactorPanels panels;
  for (const auto& [rows, columns] :
       {std::pair{3, 3}, {15, 6}, {40, 9}, {130, 33}, {300, 192}, {450, 450}}) {
    const Eigen::MatrixXd P = waves(rows, columns).triangularView<Eigen::Lower>();
    const FactorPanels::Panel panel = panels.add(P);
    const int padded = panel.tiles() * FactorPanels::kTile;
    for (const int vectors : {1, 4, 5, 6, 7, 8}) {
      using Side = Eigen::Matrix<float, 8, Eigen::Dynamic>;
      Side x = Side::Zero(8, columns);
      x.topRows(vectors) = waves(columns, vectors).transpose().cast<float>();
      Side scaled = Side::Zero(8, columns + 1);
      Side out = Side::Zero(8, padded);
      panels.scale_eight(panel, x.data(), scaled.data());
      panels.multiply_eight(panel, scaled.data(), vectors, 0, panel.tiles(), out.data());
      Side y = Side::Zero(8, padded);
      y.topLeftCorner(vectors, rows) = waves(rows, vectors).transpose().cast<float>();
      Side tiles = Side::Zero(8, padded);
      FactorPanels::lay_out_tiles(y.data(), rows, tiles.data());
      Side back = Side::Zero(8, columns);
      panels.multiply_transposed_eight(panel, tiles.data(), vectors, 0, panel.pairs(), back.data());
      for (int c = 0; c < vectors; ++c) {
        const Eigen::VectorXf x_c = x.row(c);
        std::vector<float> alone_scaled(static_cast<std::size_t>(columns) + 1);
        Eigen::VectorXf alone(padded);
        panels.scale(panel, x_c.data(), alone_scaled.data());
        panels.multiply(panel, alone_scaled.data(), 0, panel.tiles(), alone.data());
        EXPECT_LT((out.row(c).transpose() - alone).head(rows).cwiseAbs().maxCoeff(),
                  1e-5F * x_c.lpNorm<1>());
        const Eigen::VectorXf y_c = y.row(c);
        Eigen::VectorXf alone_back(columns);
        panels.multiply_transposed(panel, y_c.data(), 0, panel.pairs(), alone_back.data());
        EXPECT_LT((back.row(c).transpose() - alone_back).cwiseAbs().maxCoeff(),
                  1e-5F * y_c.lpNorm<1>());
      }
    }
  }
}

constexpr PreconditionerKind kKinds[] = {PreconditionerKind::BlockJacobi,
                                         PreconditionerKind::RestFactor,
                                         PreconditionerKind::WarpedRestFactor};

/// Rotations of no effect at rest, so that the warped factor is as good as the other.
std::vector<NodeRotation> unturned(std::size_t nodes) {
  NodeRotation one{};
  for (int k = 0; k < 3; ++k) one.row[k][k] = one.column[k][k] = 1.0F;
  return std::vector<NodeRotation>(nodes, one);
}

// What a cap leaves: told as a failure, or taken with its residual, which is that of the matrix.
TEST(PcgSolver, TakesWhatItsCapHasReachedOnlyWhereItMay) {
  const LugSystem lug;
  const Eigen::VectorXd b = waves(3 * lug.pattern().rows(), 1);
  SolverParams params{.kind = SolverKind::Pcg, .tolerance = 1e-12, .max_iterations = 5};
  for (const bool accepts : {false, true}) {
    params.accept_unconverged = accepts;
    PcgSolver solver(params, lug.pattern(), nullptr, nullptr);
    ASSERT_EQ(solver.factorize(lug.A).outcome, Outcome::Done);
    Eigen::MatrixXd x = b;
    const SolveReport report = solver.solve(x, Eigen::VectorXd::Constant(1, b.norm()));
    EXPECT_EQ(report.outcome, accepts ? Outcome::Done : Outcome::NotConverged);
    EXPECT_EQ(report.message.empty(), accepts);
    EXPECT_EQ(report.iterations, 5);
    const double left = (b - multiply(lug.pattern(), lug.A, x.col(0))).norm();
    EXPECT_GT(left, 1e-6 * b.norm());  // it was not solved
    EXPECT_NEAR(report.residual, left, 1e-9 * b.norm());

    Eigen::MatrixXd columns = waves(b.size(), 3);
    const Eigen::VectorXd norms = columns.colwise().norm();
    const SolveReport several = solver.solve(columns, norms);
    EXPECT_EQ(several.outcome, report.outcome);
    EXPECT_EQ(several.iterations, 15);
  }
}

// No number is no solution, whatever may be taken.
TEST(PcgSolver, NeverTakesWhatIsNoNumber) {
  const LugSystem lug;
  PcgSolver solver({.kind = SolverKind::Pcg, .max_iterations = 5, .accept_unconverged = true},
                   lug.pattern(), nullptr, nullptr);
  ASSERT_EQ(solver.factorize(lug.A).outcome, Outcome::Done);
  for (const Eigen::Index columns : {1, 3}) {
    Eigen::MatrixXd x = waves(3 * lug.pattern().rows(), columns);
    x(7, 0) = std::nan("");
    const Eigen::VectorXd norms = Eigen::VectorXd::Ones(columns);
    EXPECT_NE(solver.solve(x, norms).outcome, Outcome::Done) << columns;
  }
}

// Each column ends at its residual's tolerance, measured with the matrix itself (the recursion's
// own drift is 1e-16 κ); what the rough solve says is left is the residual. Columns of widely
// different sizes and one of zeros do not disturb the others.
TEST(PcgColumns, EveryColumnIsSolvedToTheTolerance) {
  const LugSystem lug;
  const BlockPattern& pattern = lug.pattern();
  const RestFactor rest(pattern, lug.A);
  for (const PreconditionerKind kind : kKinds) {
    const double tolerance = 1e-8;
    PcgSolver solver({.kind = SolverKind::Pcg, .tolerance = tolerance, .preconditioner = kind},
                     pattern, &rest, nullptr);
    ASSERT_EQ(solver.factorize(lug.A, unturned(lug.model.free.size())).outcome, Outcome::Done);
    for (const Eigen::Index columns : {2, 6, 9, 17}) {
      Eigen::MatrixXd b = waves(3 * pattern.rows(), columns);
      b.col(0).setZero();
      b.col(1) *= 1e-30;
      const Eigen::VectorXd norms = b.colwise().norm();
      Eigen::MatrixXd x = b;
      ASSERT_EQ(solver.solve(x, norms).outcome, Outcome::Done);
      Eigen::MatrixXd rough = b;
      Eigen::MatrixXd left;
      ASSERT_EQ(solver.solve_roughly(rough, norms, left).outcome, Outcome::Done);
      for (Eigen::Index c = 0; c < columns; ++c) {
        const Eigen::VectorXd r = b.col(c) - multiply(pattern, lug.A, x.col(c));
        EXPECT_LE(r.norm(), 1.001 * tolerance * norms(c)) << c;
        const Eigen::VectorXd rough_r = b.col(c) - multiply(pattern, lug.A, rough.col(c));
        EXPECT_LE(rough_r.norm(), 1.001 * std::sqrt(tolerance) * norms(c)) << c;
        EXPECT_LE((rough_r - left.col(c)).norm(), 1e-12 * norms(c)) << c;
      }
    }
  }
}

TEST(PcgColumns, GiveTheSameBitsForAnyThreadsAndVectorInstructions) {
  const LugSystem lug;
  const BlockPattern& pattern = lug.pattern();
  const RestFactor rest(pattern, lug.A);
  const Eigen::MatrixXd b = waves(3 * pattern.rows(), 6);
  const Eigen::VectorXd norms = b.colwise().norm();
  for (const PreconditionerKind kind : kKinds) {
    const auto solution = [&](int threads) {
      ThreadTeam team(threads);
      PcgSolver solver({.kind = SolverKind::Pcg, .tolerance = 1e-6, .preconditioner = kind},
                       pattern, &rest, &team);
      EXPECT_EQ(solver.factorize(lug.A, unturned(lug.model.free.size())).outcome, Outcome::Done);
      Eigen::MatrixXd x = b;
      EXPECT_EQ(solver.solve(x, norms).outcome, Outcome::Done);
      return x;
    };
    const Eigen::MatrixXd alone = solution(1);
    EXPECT_EQ(solution(2), alone);
    EXPECT_EQ(solution(3), alone);
    for (const VectorUnit unit : {VectorUnit::Avx2, VectorUnit::Plain}) {
      limit_vector_unit(unit);
      EXPECT_EQ(solution(1), alone);
    }
    limit_vector_unit(VectorUnit::Avx512);
  }
}

InterfaceJacobian jacobian_with(const SolverParams& solver) {
  Params params = bar_with_two_ports();
  params.solver = solver;
  const SimTime h = params.micro_step;
  FlexibleBody body(params);
  body.initialize(pair_motion(0.0));
  return body.advance(request(pair_motion(0.0), pair_motion(to_seconds(h)), h, true))
      .jacobian.value();
}

/// Largest error of a kind of row, relative to the largest entry of that kind.
double rough_error(double tolerance) {
  const InterfaceJacobian exact = jacobian_with({.kind = SolverKind::Cholmod});
  const InterfaceJacobian rough =
      jacobian_with({.kind = SolverKind::Pcg,
                     .tolerance = tolerance,
                     .preconditioner = PreconditionerKind::BlockJacobi});
  double worst = 0.0;
  for (Eigen::Index row = 0; row < 12; row += 3) {
    worst = std::max(worst, (rough - exact).middleRows(row, 3).cwiseAbs().maxCoeff() /
                                exact.middleRows(row, 3).cwiseAbs().maxCoeff());
  }
  return worst;
}

// Columns whose residuals are √tolerance would leave an error of that order in the wrench's
// derivative; with the residuals' share it is their square, the tolerance, times the step matrix's
// conditioning (some tens here) and the turn of the arms within the step.
TEST(FemInterfaceJacobian, OfRoughColumnsIsOfSecondOrderInTheirResiduals) {
  EXPECT_LT(rough_error(1e-4), 30 * 1e-4);
  EXPECT_LT(rough_error(1e-6), 30 * 1e-6);
  EXPECT_LT(rough_error(1e-8), 30 * 1e-8);
}

}  // namespace
}  // namespace tandem::fem
