#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "fem_process/elements/corotational_tet4.h"
#include "fem_process/kernels/polar.h"
#include "fem_process/matrix/node_rotations.h"
#include "fem_process/sides/step_benchmark.h"
#include "fem_process/solvers/cholmod_solver.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

constexpr SimTime kStep{1'000'000};

SolverParams pcg(PreconditionerKind preconditioner, double tolerance = 1e-12) {
  return {.kind = SolverKind::Pcg, .tolerance = tolerance, .preconditioner = preconditioner};
}

/// Both ports of the bar turn together about z at 150 rad/s, and bend and stretch it meanwhile.
MotionSet whirl(double t) {
  MotionSet motions = pair_motion(0.0);
  const double w = 150.0;
  for (std::size_t p = 0; p < 2; ++p) {
    const double sign = p == 0 ? -1.0 : 1.0;
    const Eigen::Quaterniond q = rotation(Eigen::Vector3d(0, 0, w * t));
    const Eigen::Vector3d arm(sign * (0.28 + 0.5 * t), 0.3 * t, sign * 0.4 * t);
    const Eigen::Vector3d arm_dot(sign * 0.5, 0.3, sign * 0.4);
    Motion& m = motions[p];
    m.q_WP = q;
    m.w_WP = Eigen::Vector3d(0, 0, w);
    m.p_WP = q * arm;
    m.v_WP = m.w_WP.cross(m.p_WP) + q * arm_dot;
  }
  return motions;
}

struct Path {
  std::vector<StepResult<WrenchSet>> results;
  Eigen::VectorXd x;
};

/// `steps` steps of the whirling bar, every one made twice when `repeat`: with another end first,
/// then rolled back.
Path run_whirl(const SolverParams& solver, int steps, bool repeat = false, bool linearize = false,
               int order = 1) {
  Params params = bar_with_two_ports();
  params.mesh.order = order;
  params.solver = solver;
  FlexibleBody body(params);
  body.initialize(whirl(0.0));
  body.checkpoint();
  Path path;
  for (int n = 0; n < steps; ++n) {
    const double t = n * to_seconds(kStep);
    const double next = t + to_seconds(kStep);
    if (repeat) {
      body.advance(request(whirl(t), whirl(next + 2e-4), kStep));
      body.advance(request(whirl(next + 2e-4), whirl(next + 1e-3), kStep));
      body.rollback();
    }
    path.results.push_back(body.advance(request(whirl(t), whirl(next), kStep, linearize)));
    EXPECT_EQ(path.results.back().outcome, Outcome::Done) << path.results.back().message;
    body.checkpoint();
  }
  path.x = body.state().x;
  return path;
}

// 30 steps turn the bar by 4.5 rad. PCG stops at 1e-12 of the right-hand side, the bar's step
// matrix has a condition number near 1e3: 1e-9 of the wrenches' size.
TEST(FemPreconditioners, GiveTheWrenchesAndPositionsOfCholeskyInLargeRotationAndAfterRollbacks) {
  const Path direct = run_whirl({.kind = SolverKind::Cholmod}, 30);
  for (const auto kind : {PreconditionerKind::BlockJacobi, PreconditionerKind::RestFactor,
                          PreconditionerKind::WarpedRestFactor}) {
    const Path path = run_whirl(pcg(kind), 30, /*repeat=*/true);
    EXPECT_LT((path.x - direct.x).norm(), 1e-10 * direct.x.norm());
    for (std::size_t n = 0; n < path.results.size(); ++n) {
      const Eigen::VectorXd expected = stack(direct.results[n].output);
      EXPECT_LT((stack(path.results[n].output) - expected).norm(), 1e-9 * expected.norm()) << n;
    }
  }
}

// The warped factor of second-order tets turns with the bar, too: at 3 rad it takes no more
// iterations than at 1.5 rad. Tolerances as above.
TEST(FemPreconditioners, GiveTheWrenchesOfCholeskyWithSecondOrderTets) {
  const Path direct = run_whirl({.kind = SolverKind::Cholmod}, 20, false, false, 2);
  const Path path = run_whirl(pcg(PreconditionerKind::WarpedRestFactor), 20, true, false, 2);
  EXPECT_LT((path.x - direct.x).norm(), 1e-10 * direct.x.norm());
  for (std::size_t n = 0; n < path.results.size(); ++n) {
    const Eigen::VectorXd expected = stack(direct.results[n].output);
    EXPECT_LT((stack(path.results[n].output) - expected).norm(), 1e-9 * expected.norm()) << n;
  }
  EXPECT_LE(path.results[19].solver_iterations, path.results[9].solver_iterations + 2);
}

// What a rollback must restore is the state alone: with and without discarded steps the same bits.
TEST(FemPreconditioners, GiveTheSameBitsWithAndWithoutDiscardedSteps) {
  const SolverParams solver = pcg(PreconditionerKind::WarpedRestFactor);
  const Path once = run_whirl(solver, 20);
  const Path again = run_whirl(solver, 20, /*repeat=*/true);
  EXPECT_EQ(once.x, again.x);
  for (std::size_t n = 0; n < once.results.size(); ++n) {
    EXPECT_EQ(stack(once.results[n].output), stack(again.results[n].output)) << n;
  }
}

// Every column is solved to 1e-12 of its right-hand side.
TEST(FemPreconditioners, GiveTheInterfaceJacobianOfCholesky) {
  const Path direct = run_whirl({.kind = SolverKind::Cholmod}, 12, false, true);
  const Path path = run_whirl(pcg(PreconditionerKind::WarpedRestFactor), 12, false, true);
  const InterfaceJacobian& expected = *direct.results.back().jacobian;
  EXPECT_LT((*path.results.back().jacobian - expected).cwiseAbs().maxCoeff(),
            1e-9 * expected.cwiseAbs().maxCoeff());
}

// The warped factor turns with the bar: its iterations at 4.5 rad are no more than at 1.5 rad,
// while the factor left behind needs many times as many.
TEST(FemPreconditioners, WarpMakesIterationsIndependentOfRotation) {
  const auto iterations = [](PreconditionerKind kind, std::size_t step) {
    return run_whirl(pcg(kind), 30).results[step - 1].solver_iterations;
  };
  const int at_once = iterations(PreconditionerKind::WarpedRestFactor, 10);
  const int later = iterations(PreconditionerKind::WarpedRestFactor, 30);
  EXPECT_LE(later, at_once);
  EXPECT_GT(iterations(PreconditionerKind::RestFactor, 30), 5 * later);
}

// Counts of the standard lug (1455 tets, soft, 1e-6), as published for these methods' prototype:
// 220 with diagonal blocks, 27 with the factor at rest, 7 when it is warped, 3.8 when it starts
// from a projection on eight past velocities (of which the first steps have fewer).
TEST(FemPreconditioners, CutTheIterationsOfTheStandardLug) {
  const auto iterations = [](PreconditionerKind kind, InitialGuess guess) {
    SolverParams solver = pcg(kind, 1e-6);
    solver.initial_guess = guess;
    const Params params =
        benchmark_params(benchmark_case("soft"), data_file("lug_1k.msh"), "clamp", "eye", solver);
    return run_benchmark(params, 100).iterations_mean;
  };
  EXPECT_NEAR(iterations(PreconditionerKind::BlockJacobi, InitialGuess::Previous), 191.0, 5.0);
  EXPECT_NEAR(iterations(PreconditionerKind::RestFactor, InitialGuess::Previous), 21.5, 3.0);
  EXPECT_NEAR(iterations(PreconditionerKind::WarpedRestFactor, InitialGuess::Previous), 5.65, 0.5);
  EXPECT_LT(iterations(PreconditionerKind::WarpedRestFactor, InitialGuess::Projection), 3.8);
}

// The positions of a rotated body are linear in the reference ones: every node's F is R itself.
// Kept in single precision: 6e-8 for each of nine numbers below 1.
TEST(NodeRotations, OfARigidlyTurnedBodyAreItsRotation) {
  const Model model(bar_with_two_ports());
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
      for (int j = 0; j < 3; ++j) {
        EXPECT_NEAR(node.row[i][j], R(i, j), 1.2e-7);
        EXPECT_EQ(node.column[j][i], node.row[i][j]);
      }
    }
  }
}

// The kernel's forces and stiffness are those of element matrices that are rotated one by one, also
// where corners have passed through opposite faces; sums of some ten elements, a few hundred ε
// each.
TEST(CorotationalKernel, EqualsRotatedElementMatrices) {
  const TetMesh mesh = read_mesh({.file = data_file("bar.msh")});
  const CorotationalTet4 formulation(mesh, {.young_Pa = 5e6, .poisson = 0.3});
  Eigen::VectorXd x(3 * mesh.nodes());
  const Eigen::Matrix3d turn = rotation({0.5, 1.0, -0.7}).toRotationMatrix();
  for (int i = 0; i < mesh.nodes(); ++i) {
    const Eigen::Vector3d shake(std::sin(1.0 + i), std::sin(2.0 + 3 * i), std::sin(5.0 + 7 * i));
    x.segment<3>(3 * i) = turn * mesh.X[static_cast<std::size_t>(i)] + 0.012 * shake;
  }
  Eigen::VectorXd f = Eigen::VectorXd::Zero(x.size());
  BlockValues K(9 * formulation.pattern().blocks(), 0.0);
  int inverted = 0;
  for (const Tet4& element : formulation.elements()) {
    const Eigen::Matrix3d edges = edges_of(element.nodes, x);
    const PolarRotation polar = polar_rotation(edges * element.gradients.bottomRows<3>());
    inverted += polar.inverted ? 1 : 0;
    Matrix12d T = Matrix12d::Zero();
    Vector12d u;
    for (int i = 0; i < 4; ++i) {
      const int node = element.nodes[static_cast<std::size_t>(i)];
      T.block<3, 3>(3 * i, 3 * i) = polar.R;
      u.segment<3>(3 * i) =
          polar.R.transpose() * x.segment<3>(3 * node) - mesh.X[static_cast<std::size_t>(node)];
    }
    const Vector12d f_e = T * (element.K * u);
    for (int i = 0; i < 4; ++i) {
      f.segment<3>(3 * element.nodes[static_cast<std::size_t>(i)]) += f_e.segment<3>(3 * i);
    }
    add_element_matrix(element, T * element.K * T.transpose(), K);
  }
  EXPECT_GT(inverted, 3);
  EXPECT_LT(inverted, static_cast<int>(mesh.tets.size()) / 2);
  Eigen::VectorXd kernel_f;
  BlockValues kernel_K;
  EXPECT_EQ(formulation.evaluate(x, kernel_f, kernel_K), inverted);
  EXPECT_LT((kernel_f - f).cwiseAbs().maxCoeff(), 1e-11 * f.cwiseAbs().maxCoeff());
  const auto values = [](const BlockValues& K_) {
    return Eigen::Map<const Eigen::VectorXd>(K_.data(), static_cast<Eigen::Index>(K_.size()));
  };
  EXPECT_LT((values(kernel_K) - values(K)).cwiseAbs().maxCoeff(),
            1e-12 * values(K).cwiseAbs().maxCoeff());
}

// A part of a product is the same numbers as the whole.
TEST(BlockMatrix, PartsOfAProductEqualTheWhole) {
  const Model model(bar_with_two_ports());
  Eigen::VectorXd f_int;
  BlockValues K;
  model.formulation->evaluate(model.reference(), f_int, K);
  EightVectors X = EightVectors::Zero(8, 3 * model.mesh.nodes());
  for (Eigen::Index i = 0; i < X.size(); ++i) X(i) = std::sin(1.0 + 0.3 * static_cast<double>(i));
  EightVectors Y;
  ThreadTeam alone;
  multiply_eight(model.pattern(), K, X, Y, alone);
  const double round_off = 1e-13 * Y.cwiseAbs().maxCoeff();
  for (Eigen::Index k = 0; k < 8; ++k) {
    const Eigen::VectorXd x = X.row(k).transpose();
    const Eigen::VectorXd whole = multiply(model.pattern(), K, x);
    EXPECT_LT((Y.row(k).transpose() - whole).cwiseAbs().maxCoeff(), round_off);
    const Eigen::VectorXd rows = multiply(model.pattern(), K, x, {.rows = &model.prescribed});
    for (int node : model.prescribed) {
      EXPECT_EQ(rows.segment<3>(3 * node), whole.segment<3>(3 * node));
    }
  }
}

}  // namespace
}  // namespace tandem::fem
