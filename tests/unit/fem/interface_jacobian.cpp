#include <gtest/gtest.h>

#include <tuple>

#include "tests/support/fem_box.h"
#include "tests/support/fem_jacobian.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

// The wrench is linear in p, v, w, where central differences are exact, and a sine in the angle,
// where 1e-3 rad leaves 1e-6/6 of the value; round-off is 1e-16 · (force ~ 1e3 N) / 1e-3.
TEST(FemInterfaceJacobian, MatchesCentralDifferencesForBackwardEuler) {
  EXPECT_LT(jacobian_error(bar_with_two_ports(), 1, 1e-3), 1e-6);
}

// The torques' balance of angular momentum has rows of its own for each of these. Over micro steps
// the rounding of positions in between is left: see MatchesCentralDifferencesOverMicroSteps.
TEST(FemInterfaceJacobian, MatchesCentralDifferencesForBackwardEulerOfEveryKind) {
  for (FormulationKind formulation :
       {FormulationKind::Linear, FormulationKind::Corotational,
        FormulationKind::ConsistentCorotational, FormulationKind::TotalLagrangian}) {
    for (int micro_steps : {1, 3}) {
      for (bool grounded : {false, true}) {
        for (double alpha_per_s : {0.0, 3.0}) {
          Params params = bar_with_two_ports();
          params.formulation = formulation;
          if (grounded) {
            params.mesh.file =
                temporary_file("grounded.inp", box_inp(4) + "*NSET, NSET=MIDDLE\n9, 10, 11, 12\n");
            params.mesh.length_scale_m = 0.1;
            params.ports = {{"left", {"LEFT"}, Eigen::Vector3d(-0.1, 0, 0)},
                            {"right", {"RIGHT"}, Eigen::Vector3d(0.5, 0, 0)}};
            params.fixed = {{"MIDDLE"}};
          }
          params.damping.alpha_per_s = alpha_per_s;
          EXPECT_LT(jacobian_error(params, micro_steps, 1e-3), micro_steps == 1 ? 1e-6 : 2e-6)
              << static_cast<int>(formulation) << micro_steps << grounded << alpha_per_s;
        }
      }
    }
  }
}

TEST(FemInterfaceJacobian, MatchesCentralDifferencesWithDamping) {
  Params params = bar_with_two_ports();
  params.damping = {.alpha_per_s = 3.0, .beta_s = 2e-3};
  EXPECT_LT(jacobian_error(params, 1, 1e-3), 1e-6);
}

// The second-order methods take their forces anew at the first solution, so the wrench is nonlinear
// in all of the motion: 1e-4 (m, rad, m/s) leaves a hundredth of what 1e-3 does.
TEST(FemInterfaceJacobian, MatchesCentralDifferencesForHht) {
  Params params = bar_with_two_ports();
  params.integrator = {.kind = IntegratorKind::Hht, .hht_alpha = -0.1};
  params.damping = {.alpha_per_s = 3.0, .beta_s = 2e-3};
  EXPECT_LT(jacobian_error(params, 1, 1e-4), 1e-6);
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
// and the turning of the elements there. Positions in between are rounded before forces are made of
// them: 5e-17 m on a stiffness of 1e9 N/m, which the differences divide by 1e-4, is 1e-6 of an
// entry.
TEST(FemInterfaceJacobian, MatchesCentralDifferencesOverMicroSteps) {
  EXPECT_LT(jacobian_error(bar_with_two_ports(), 3, 1e-4), 2e-6);
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
    EXPECT_LT(jacobian_error(params, 1, 1e-4), 1e-6);
    EXPECT_LT(jacobian_error(params, 3, 1e-4), 1e-6);
  }
}

// Iterated to equilibrium: the derivative is that of the equilibrium, whatever tangent found it.
// The wrench is nonlinear in the displacements: 1e-4 (m, rad) on elements of 2e-2 m leaves the
// fourth power of their ratio; the differences divide the round-off of the equilibrium, 1e-13 of
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
  EXPECT_LT(jacobian_error(params, micro_steps, from_velocities ? 1e-3 : 1e-4), 1e-6);
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

// Backward Euler takes port displacements from velocities: the port's position has no influence on
// forces. Where the body ends up has moments of its momentum, M v, which the torque balances.
TEST(FemInterfaceJacobian, PositionsMoveNoForcesWithBackwardEuler) {
  FlexibleBody body(bar_with_two_ports());
  body.initialize(pair_motion(0.0));
  const auto result = body.advance(
      request(pair_motion(0.0), pair_motion(1e-3), SimTime(1'000'000), /*linearize=*/true));
  ASSERT_TRUE(result.jacobian.has_value());
  for (Eigen::Index port : {0, 1}) {
    EXPECT_EQ((result.jacobian->block<3, 3>(6 * port, 0).norm()), 0.0);
    EXPECT_EQ((result.jacobian->block<3, 3>(6 * port, 12).norm()), 0.0);
  }
}

}  // namespace
}  // namespace tandem::fem
