// The factor of a macro step's first micro step serves the others.
#include "fem_process/solvers/nearby_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

#include "fem_process/elements/corotational_tet4.h"
#include "fem_process/matrix/node_rotations.h"
#include "fem_process/solvers/cholmod_solver.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

/// Both ports turn together about z at 150 rad/s while they bend and stretch the bar.
MotionSet whirl(double t) {
  MotionSet motions = pair_motion(0.0);
  const Eigen::Vector3d w(0, 0, 150.0);
  for (std::size_t p = 0; p < 2; ++p) {
    const double sign = p == 0 ? -1.0 : 1.0;
    const Eigen::Quaterniond q = rotation(w * t);
    const Eigen::Vector3d arm(sign * (0.28 + 0.5 * t), 0.3 * t, sign * 0.4 * t);
    motions[p].q_WP = q;
    motions[p].w_WP = w;
    motions[p].p_WP = q * arm;
    motions[p].v_WP = w.cross(motions[p].p_WP) + q * Eigen::Vector3d(sign * 0.5, 0.3, sign * 0.4);
  }
  return motions;
}

// A macro step of four micro steps, 0.6 rad, against four macro steps through the same motions,
// each with a factor of its own: what the solver leaves, 1e-14, times the condition number, 1e3.
TEST(NearbySolver, MicroStepsAreThoseWithAFactorEach) {
  const SimTime h(1'000'000);
  Params params = bar_with_two_ports();
  params.micro_step = h;
  FlexibleBody together(params);
  FlexibleBody apart(params);
  together.initialize(whirl(0.0));
  apart.initialize(whirl(0.0));
  for (int n = 0; n < 3; ++n) {
    const double t = 4 * n * to_seconds(h);
    const Segment<MotionSet> input{whirl(t), whirl(t + 4 * to_seconds(h))};
    const auto whole = together.advance(request(input.begin, input.end, 4 * h));
    ASSERT_EQ(whole.outcome, Outcome::Done) << whole.message;
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(12);
    for (int j = 0; j < 4; ++j) {
      const auto at = [&](int k) {
        return k == 0 ? input.begin : interpolate(input, k / 4.0, 4 * h, VelocityRule::Linear);
      };
      WrenchSet wrenches = apart.advance(request(at(j), at(j + 1), h)).output;
      // Torques are taken about the ports' origins at the beginning of the macro step.
      for (std::size_t p = 0; p < wrenches.size(); ++p) {
        wrenches[p].t_P_W += (at(j)[p].p_WP - input.begin[p].p_WP).cross(wrenches[p].f_P_W);
      }
      mean += 0.25 * stack(wrenches);
    }
    EXPECT_LT((stack(whole.output) - mean).norm(), 1e-10 * mean.norm()) << n;
    EXPECT_LT((together.state().x - apart.state().x).norm(), 1e-12 * apart.state().x.norm());
  }
}

/// M/h + h K of the whole bar, bent and turned by some angle about z.
struct StepMatrix {
  BlockValues S;
  std::vector<NodeRotation> rotations;
};

StepMatrix step_matrix(const Model& model, double angle, double h_s) {
  const Eigen::Quaterniond q = rotation(Eigen::Vector3d(0, 0, angle));
  Eigen::VectorXd x = model.reference();
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    x[i + 1] += 0.2 * x[i] * x[i];
    x.segment<3>(i) = (q * x.segment<3>(i)).eval();
  }
  StepMatrix made;
  Eigen::VectorXd f_int;
  BlockValues K;
  model.formulation->evaluate(x, f_int, K);
  std::vector<int> all;
  for (int i = 0; i < model.mesh.nodes(); ++i) all.push_back(i);
  NodeRotations(model.mesh, model.pattern(), all).at(x, made.rotations, *model.team);
  made.S = K;
  for (double& value : made.S) value *= h_s;
  for (int i = 0; i < model.mesh.nodes(); ++i) {
    block(made.S, model.pattern().find(i, i)).diagonal().array() +=
        model.nodal_mass[static_cast<std::size_t>(i)] / h_s;
  }
  return made;
}

struct Answer {
  Eigen::MatrixXd nearby, direct;
  int iterations = 0;
};

Answer solve_with(const StepMatrix& neighbour, const StepMatrix& A, const Model& model) {
  CholmodSolver first(model.pattern());
  first.factorize(neighbour.S);
  NearbySolver nearby(model.pattern(), first, neighbour.rotations);
  nearby.factorize(A.S, A.rotations);
  CholmodSolver own(model.pattern());
  own.factorize(A.S);
  Answer answer;
  answer.nearby = Eigen::MatrixXd::Random(3 * model.mesh.nodes(), 2);
  answer.direct = answer.nearby;
  const Eigen::VectorXd norms = answer.nearby.colwise().norm();
  const SolveReport report = nearby.solve(answer.nearby, norms);
  EXPECT_EQ(report.outcome, Outcome::Done) << report.message;
  answer.iterations = report.iterations;
  own.solve(answer.direct, norms);
  return answer;
}

// The warp takes the turn out: a few iterations for any angle.
TEST(NearbySolver, TurnsTheNeighboursFactorWithTheNodes) {
  const Model model(bar_with_two_ports());
  const StepMatrix neighbour = step_matrix(model, 0.0, 1e-3);
  for (double angle : {0.1, 2.0}) {
    const Answer answer = solve_with(neighbour, step_matrix(model, angle, 1e-3), model);
    EXPECT_LT((answer.nearby - answer.direct).norm(), 1e-11 * answer.direct.norm()) << angle;
    EXPECT_LE(answer.iterations, 2 * 4) << angle;
  }
}

// A step ten times as long is no neighbour: the matrix is factorised, with CHOLMOD's own bits.
TEST(NearbySolver, FactorisesWhereTheNeighbourIsFar) {
  const Model model(bar_with_two_ports());
  const Answer answer =
      solve_with(step_matrix(model, 0.0, 1e-5), step_matrix(model, 0.3, 1e-2), model);
  EXPECT_EQ(answer.nearby, answer.direct);
}

}  // namespace
}  // namespace tandem::fem
