#include "protocol/schemes/accelerator.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/support/split_oscillator.h"

namespace tandem {
namespace {

using Case = test::SplitOscillator;
using Kind = QuasiNewton::Kind;

/// x ← A x + b with eigenvalues of A of size 3: plain iteration diverges.
struct AffineMap {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  [[nodiscard]] Eigen::VectorXd residual(const Eigen::VectorXd& x) const { return A * x + b - x; }
};

AffineMap affine_map(Eigen::Index n, double shift) {
  AffineMap map{.A = Eigen::MatrixXd(n, n), .b = Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      map.A(i, j) = -3.0 * (i == j) + 0.3 * std::sin(static_cast<double>(3 * i + 5 * j));
    }
    map.b(i) = std::cos(static_cast<double>(i)) + shift;
  }
  return map;
}

/// Evaluations until ‖r‖ ≤ 1e-10 from x = 0; 50 = not within 50.
int evaluations(Accelerator& accelerator, const AffineMap& map, bool last_accepted) {
  const Eigen::Index n = map.b.size();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  accelerator.begin_step(Eigen::VectorXd::Ones(n), last_accepted);
  for (int k = 1; k < 50; ++k) {
    const Eigen::VectorXd r = map.residual(x);
    accelerator.observe(x, r);
    if (r.norm() <= 1e-10) return k;
    x = accelerator.next();
  }
  return 50;
}

// n + 1 evaluations give n secant pairs: the Jacobian is known, and the next iterate is exact.
TEST(QuasiNewton, IsExactOnAnAffineMapOnceItHasASecantForEveryUnknown) {
  for (Kind kind : {Kind::Ils, Kind::Imvj}) {
    QuasiNewton qn(kind, 0, 1e-8, 0.5);
    EXPECT_LE(evaluations(qn, affine_map(5, 0.0), false), 5 + 2);
  }
}

// The Jacobian is that of the step before: the first evaluation gives the residual, the next x is
// exact.
TEST(QuasiNewton, NeedsTwoEvaluationsWithWhatTheLastStepHasTaught) {
  for (Kind kind : {Kind::Ils, Kind::Imvj}) {
    QuasiNewton qn(kind, 1, 1e-8, 0.5);
    (void)evaluations(qn, affine_map(5, 0.0), false);
    EXPECT_LE(evaluations(qn, affine_map(5, 2.0), true), 3);
  }
}

TEST(QuasiNewton, ForgetsAStepThatWasNotAccepted) {
  for (Kind kind : {Kind::Ils, Kind::Imvj}) {
    QuasiNewton qn(kind, 4, 1e-8, 0.5);
    const int first = evaluations(qn, affine_map(5, 0.0), false);
    EXPECT_EQ(evaluations(qn, affine_map(5, 0.0), false), first);
  }
}

TEST(QuasiNewton, KeepsColumnsOfNoMoreStepsThanItIsTold) {
  QuasiNewton qn(Kind::Ils, 2, 1e-8, 0.5);
  for (int step = 0; step < 3; ++step) (void)evaluations(qn, affine_map(4, step), true);
  // The map changes: with the old columns gone after two steps it is learnt anew, exactly.
  AffineMap other = affine_map(4, 0.0);
  other.A *= -0.5;
  int last = 0;
  for (int step = 0; step < 5; ++step) last = evaluations(qn, other, true);
  EXPECT_LE(last, 3);
}

// Anderson's acceleration with all columns spans the Krylov space of GMRES: A = −3 I has a minimal
// polynomial of degree one, so one secant pair is enough whatever the dimension.
TEST(QuasiNewton, NeedsAsManySecantsAsTheMapHasEigenvalues) {
  AffineMap map = affine_map(12, 0.0);
  map.A = -3.0 * Eigen::MatrixXd::Identity(12, 12);
  QuasiNewton qn(Kind::Ils, 0, 1e-8, 0.5);
  EXPECT_EQ(evaluations(qn, map, false), 3);
}

// Two columns that differ by 1e-6 of their length: kept by a fine filter, dropped by a coarse one,
// and the coarse one's step then stays bounded where the fine one's explodes.
TEST(QuasiNewton, FilterLeavesOutColumnsThatAreAlmostDependent) {
  const auto step_size = [](double filter) {
    QuasiNewton qn(Kind::Ils, 0, filter, 0.5);
    qn.begin_step(Eigen::VectorXd::Ones(2), false);
    qn.observe(Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.0, 1.0));
    qn.observe(Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(1.0, 1.0));
    qn.observe(Eigen::Vector2d(2.0, 0.5), Eigen::Vector2d(2.0, 1.0 + 1e-6));
    return (qn.next() - Eigen::Vector2d(2.0, 0.5)).norm();
  };
  EXPECT_GT(step_size(1e-9), 1e5);
  EXPECT_LT(step_size(1e-3), 10.0);
}

CouplingParams implicit(Relaxation relaxation, Iteration iteration) {
  return {.scheme = SchemeKind::Implicit, .iteration = iteration, .relaxation = relaxation};
}

// Mass ratio up to 100 and a stiff spring: κ from 1.5 to 140.
TEST(ImplicitQuasiNewton, SolvesTheCoupledStepInBothForms) {
  for (Relaxation relaxation : {Relaxation::Anderson, Relaxation::IqnIls, Relaxation::IqnImvj}) {
    for (Iteration iteration : {Iteration::Serial, Iteration::Parallel}) {
      for (double fem_kg : {1.5, 10.0, 100.0}) {
        Case c{.fem_kg = fem_kg, .stiffness = 4e4};
        c.coupling = implicit(relaxation, iteration);
        const RunReport report = run(c);
        ASSERT_EQ(report.status, RunStatus::Done) << report.message;
        EXPECT_EQ(report.not_converged_steps, 0);
        // The residual limit 1e-12 relative, times κ, over 100 steps.
        EXPECT_NEAR(report.motions[0].p_WP.x(), exact_step_state(c).x, 1e-9)
            << static_cast<int>(relaxation) << " " << static_cast<int>(iteration) << " " << fem_kg;
      }
    }
  }
}

// One unknown in series: the secant method needs three evaluations of an affine map, and two once
// it knows the slope. In parallel motion and wrench are evaluated apart, which doubles that.
TEST(ImplicitQuasiNewton, LearnsAnAffineMapWithinTheFirstStep) {
  for (Relaxation relaxation : {Relaxation::IqnIls, Relaxation::IqnImvj}) {
    Case c{.fem_kg = 3.0, .stiffness = 1000.0};
    c.coupling = implicit(relaxation, Iteration::Serial);
    const RunReport serial = run(c);
    EXPECT_LE(serial.iterations_max, 3);
    EXPECT_LE(serial.iterations_total, 2 * serial.macro_steps + 1);
    c.coupling.iteration = Iteration::Parallel;
    EXPECT_LE(run(c).iterations_total, 2 * serial.iterations_total);
  }
}

TEST(ImplicitQuasiNewton, ReachingTheCapIsNotConvergence) {
  for (Iteration iteration : {Iteration::Serial, Iteration::Parallel}) {
    Case c{.fem_kg = 5.0, .stiffness = 100.0, .hardening = 1e3};
    c.coupling = implicit(Relaxation::IqnIls, iteration);
    c.coupling.max_iterations = 2;
    const RunReport report = run(c);
    EXPECT_EQ(report.status, RunStatus::NotConverged);
    EXPECT_NE(report.message.find("max_iterations"), std::string::npos) << report.message;
  }
}

}  // namespace
}  // namespace tandem
