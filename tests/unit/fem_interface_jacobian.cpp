#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "fem_process/make_side.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

Motion moved(Motion m, int coordinate, double amount) {
  const Eigen::Vector3d change = amount * Eigen::Vector3d::Unit(coordinate % 3);
  if (coordinate < 3) m.p_WP += change;
  if (coordinate >= 3 && coordinate < 6) m.q_WP = rotation(change) * m.q_WP;
  if (coordinate >= 6 && coordinate < 9) m.v_WP += change;
  if (coordinate >= 9) m.w_WP += change;
  return m;
}

/// Largest difference between the reported Jacobian and central differences, each column relative
/// to its block of three columns' largest entry per row kind (force or torque).
double jacobian_error(Params params, int micro_steps, double amount) {
  const SimTime h = params.micro_step;
  const auto owned = make_body(std::move(params));
  FemSide& body = *owned;
  body.initialize(pair_motion(0.0));
  // A few steps first, so that the bar is deformed and the port nodes carry forces.
  double t = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double next = t + to_seconds(h);
    EXPECT_EQ(body.advance(request(pair_motion(t), pair_motion(next), h)).outcome, Outcome::Done);
    t = next;
  }
  body.checkpoint();
  const SimTime H = micro_steps * h;
  StepRequest<MotionSet> asked =
      request(pair_motion(t), pair_motion(t + to_seconds(H)), H, /*linearize=*/true);
  const StepResult<WrenchSet> result = body.advance(asked);
  EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
  EXPECT_TRUE(result.jacobian.has_value());
  InterfaceJacobian differences(12, 24);
  asked.linearize = false;
  for (int column = 0; column < 24; ++column) {
    Eigen::VectorXd ends[2];
    for (int side = 0; side < 2; ++side) {
      body.rollback();
      StepRequest<MotionSet> varied = asked;
      const auto port = static_cast<std::size_t>(column / 12);
      varied.input.end[port] =
          moved(asked.input.end[port], column % 12, side == 0 ? -amount : amount);
      ends[side] = stack(body.advance(varied).output);
    }
    differences.col(column) = (ends[1] - ends[0]) / (2 * amount);
  }
  double worst = 0.0;
  for (int row = 0; row < 12; row += 3) {
    for (int column = 0; column < 24; column += 3) {
      const double scale = std::max(differences.block<3, 3>(row, column).cwiseAbs().maxCoeff(),
                                    1e-6 * differences.cwiseAbs().maxCoeff());
      const double error =
          (result.jacobian->block<3, 3>(row, column) - differences.block<3, 3>(row, column))
              .cwiseAbs()
              .maxCoeff();
      worst = std::max(worst, error / scale);
    }
  }
  return worst;
}

// The wrench is linear in p, v, w, where central differences are exact, and a sine in the angle,
// where 1e-3 rad leaves 1e-6/6 of the value; round-off is 1e-16 · (force ~ 1e3 N) / 1e-3.
TEST(FemInterfaceJacobian, MatchesCentralDifferencesForBackwardEuler) {
  EXPECT_LT(jacobian_error(bar_with_two_ports(), 1, 1e-3), 1e-6);
}

TEST(FemInterfaceJacobian, MatchesCentralDifferencesWithDamping) {
  Params params = bar_with_two_ports();
  params.damping = {.alpha_per_s = 3.0, .beta_s = 2e-3};
  EXPECT_LT(jacobian_error(params, 1, 1e-3), 1e-6);
}

TEST(FemInterfaceJacobian, MatchesCentralDifferencesForHht) {
  Params params = bar_with_two_ports();
  params.integrator = {.kind = IntegratorKind::Hht, .hht_alpha = -0.1};
  params.damping = {.alpha_per_s = 3.0, .beta_s = 2e-3};
  EXPECT_LT(jacobian_error(params, 1, 1e-3), 1e-6);
}

TEST(FemInterfaceJacobian, MatchesCentralDifferencesForSecondOrderTetsOverMicroSteps) {
  Params params = bar_with_two_ports();
  params.mesh.order = 2;
  params.integrator = {.kind = IntegratorKind::Hht, .hht_alpha = -0.1};
  params.damping = {.alpha_per_s = 3.0, .beta_s = 2e-3};
  EXPECT_LT(jacobian_error(params, 2, 1e-4), 1e-6);
}

// PCG solves the columns to its tolerance.
TEST(FemInterfaceJacobian, MatchesCentralDifferencesWithPcg) {
  Params params = bar_with_two_ports();
  params.solver = {.kind = SolverKind::Pcg, .tolerance = 1e-13};
  EXPECT_LT(jacobian_error(params, 1, 1e-3), 1e-6);
}

// With several micro steps the end motion also acts through the interpolation, the state in between
// and the turning of the elements there.
TEST(FemInterfaceJacobian, MatchesCentralDifferencesOverMicroSteps) {
  EXPECT_LT(jacobian_error(bar_with_two_ports(), 3, 1e-4), 1e-6);
}

TEST(FemInterfaceJacobian, MatchesCentralDifferencesOverHhtMicroSteps) {
  Params params = bar_with_two_ports();
  params.integrator = {.kind = IntegratorKind::Hht, .hht_alpha = -0.1};
  params.damping = {.alpha_per_s = 3.0, .beta_s = 2e-3};
  EXPECT_LT(jacobian_error(params, 3, 1e-4), 1e-6);
}

IntegratorParams newmark() { return {.kind = IntegratorKind::Newmark}; }
IntegratorParams generalised_alpha() {
  return {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.6};
}

TEST(FemInterfaceJacobian, MatchesCentralDifferencesForGeneralisedAlphaAndNewmark) {
  for (const IntegratorParams& integrator : {newmark(), generalised_alpha()}) {
    Params params = bar_with_two_ports();
    params.integrator = integrator;
    params.damping = {.alpha_per_s = 3.0, .beta_s = 2e-3};
    EXPECT_LT(jacobian_error(params, 1, 1e-3), 1e-6);
    EXPECT_LT(jacobian_error(params, 3, 1e-4), 1e-6);
  }
}

// Iterated to equilibrium: the derivative is that of the equilibrium, whatever tangent found it.
// The wrench is nonlinear in the displacements: 1e-5 (m, rad) on elements of 2e-2 m leaves the
// square of their ratio, and so does 1e-4 (m/s) over 1e-3 s with backward Euler, which takes
// displacements from velocities; the differences divide the round-off of the equilibrium, 1e-13 of
// the forces, by that amount.
class FemIteratedJacobian
    : public ::testing::TestWithParam<std::tuple<FormulationKind, IntegratorParams, int>> {};

TEST_P(FemIteratedJacobian, MatchesCentralDifferences) {
  const auto& [formulation, integrator, micro_steps] = GetParam();
  Params params = bar_with_two_ports();
  params.formulation = formulation;
  params.integrator = integrator;
  params.integrator.newton_steps = 50;
  params.integrator.newton_tolerance = 1e-12;
  params.damping = {.alpha_per_s = 3.0, .beta_s = 2e-3};
  const bool from_velocities = integrator.kind == IntegratorKind::BackwardEuler;
  EXPECT_LT(jacobian_error(params, micro_steps, from_velocities ? 1e-4 : 1e-5), 2e-6);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, FemIteratedJacobian,
    ::testing::Values(std::tuple{FormulationKind::Linear, newmark(), 1},
                      std::tuple{FormulationKind::Corotational, IntegratorParams{}, 1},
                      std::tuple{FormulationKind::Corotational, IntegratorParams{}, 3},
                      std::tuple{FormulationKind::Corotational, generalised_alpha(), 3},
                      std::tuple{FormulationKind::ConsistentCorotational, newmark(), 1},
                      std::tuple{FormulationKind::ConsistentCorotational,
                                 IntegratorParams{.kind = IntegratorKind::Hht, .hht_alpha = -0.1},
                                 3},
                      std::tuple{FormulationKind::TotalLagrangian, generalised_alpha(), 3},
                      std::tuple{FormulationKind::Corotational,
                                 IntegratorParams{.kind = IntegratorKind::QuasiStatic}, 1},
                      std::tuple{FormulationKind::TotalLagrangian,
                                 IntegratorParams{.kind = IntegratorKind::QuasiStatic}, 3}));

// Of the reduced body: floating frame, all integrators, several micro steps.
TEST(FemInterfaceJacobian, MatchesCentralDifferencesForTheReducedBody) {
  for (const char* frame : {"mean", "right", "world"}) {
    for (int micro_steps : {1, 3}) {
      for (const IntegratorParams& integrator :
           {IntegratorParams{}, IntegratorParams{.kind = IntegratorKind::Hht, .hht_alpha = -0.1},
            newmark(), generalised_alpha(),
            IntegratorParams{.kind = IntegratorKind::QuasiStatic}}) {
        Params params = bar_with_two_ports();
        params.formulation = FormulationKind::CraigBampton;
        params.craig_bampton.frame.name = frame;
        params.integrator = integrator;
        params.damping = {.alpha_per_s = 3.0, .beta_s = 2e-3};
        EXPECT_LT(jacobian_error(params, micro_steps, 1e-4), 1e-6)
            << frame << ' ' << micro_steps << ' ' << static_cast<int>(integrator.kind);
      }
    }
  }
}

// Backward Euler takes port displacements from velocities: the port's position has no influence.
TEST(FemInterfaceJacobian, HasNoPositionColumnsForBackwardEuler) {
  FlexibleBody body(bar_with_two_ports());
  body.initialize(pair_motion(0.0));
  const auto result = body.advance(
      request(pair_motion(0.0), pair_motion(1e-3), SimTime(1'000'000), /*linearize=*/true));
  ASSERT_TRUE(result.jacobian.has_value());
  EXPECT_EQ(result.jacobian->middleCols<3>(0).norm(), 0.0);
  EXPECT_EQ(result.jacobian->middleCols<3>(12).norm(), 0.0);
}

}  // namespace
}  // namespace tandem::fem
