#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "tests/support/fem_jacobian.h"
#include "tests/support/fem_ports.h"

namespace tandem::fem {
namespace {

using namespace testing;

IntegratorParams hht() { return {.kind = IntegratorKind::Hht, .hht_alpha = -0.1}; }
IntegratorParams newmark() { return {.kind = IntegratorKind::Newmark}; }
IntegratorParams generalised_alpha() {
  return {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.6};
}

/// The bar with one kind of attachment at the left and another at the right.
Params bar(const scenario::Attachment& left, const scenario::Attachment& right) {
  Params params = bar_with_two_ports();
  params.ports[0].attachment = left;
  params.ports[1].attachment = right;
  params.damping = {.alpha_per_s = 3.0, .beta_s = 2e-3};
  return params;
}

// The differences leave the fourth power of the amount over the element size (2e-2 m, half of it
// with second-order tets) or over 1 rad; round-off is 1e-16 of the forces times 1/h² of the
// accelerations over the amount.
constexpr double kAmount = 5e-4;

TEST(FemPortJacobian, MatchesCentralDifferencesForAveragingPorts) {
  for (const IntegratorParams& integrator :
       {IntegratorParams{}, hht(), newmark(), generalised_alpha()}) {
    for (int micro_steps : {1, 3}) {
      Params params = bar(averaging(), averaging(scenario::NodeWeights::Area));
      params.integrator = integrator;
      EXPECT_LT(jacobian_error(params, micro_steps, kAmount), 1e-6)
          << static_cast<int>(integrator.kind) << ' ' << micro_steps;
    }
  }
}

TEST(FemPortJacobian, MatchesCentralDifferencesForBushingsBesideOtherPorts) {
  for (const IntegratorParams& integrator :
       {IntegratorParams{}, hht(), newmark(), generalised_alpha()}) {
    for (int micro_steps : {1, 3}) {
      for (const scenario::Attachment& other : {scenario::Attachment{}, averaging()}) {
        Params params = bar(full_bushing(), other);
        params.integrator = integrator;
        EXPECT_LT(jacobian_error(params, micro_steps, kAmount), 1e-6)
            << static_cast<int>(integrator.kind) << ' ' << micro_steps;
      }
    }
  }
}

TEST(FemPortJacobian, MatchesCentralDifferencesForSecondOrderTets) {
  Params params = bar(full_bushing(), averaging(scenario::NodeWeights::Area));
  params.mesh.order = 2;
  params.integrator = hht();
  EXPECT_LT(jacobian_error(params, 2, 2e-4), 1e-6);
}

// PCG solves the columns to its tolerance.
TEST(FemPortJacobian, MatchesCentralDifferencesWithPcg) {
  Params params = bar(full_bushing(), averaging(scenario::NodeWeights::Area));
  params.solver = {.kind = SolverKind::Pcg, .tolerance = 1e-13};
  params.integrator = hht();
  EXPECT_LT(jacobian_error(params, 1, 3e-4), 5e-6);
}

// As of rigid ports iterated to equilibrium: see FemIteratedJacobian. The forces are nonlinear in
// the strains too.
TEST(FemPortJacobian, MatchesCentralDifferencesOfIteratedSteps) {
  const std::pair<FormulationKind, IntegratorParams> kinds[] = {
      {FormulationKind::Linear, newmark()},
      {FormulationKind::Corotational, generalised_alpha()},
      {FormulationKind::ConsistentCorotational, IntegratorParams{}},
      {FormulationKind::TotalLagrangian, hht()}};
  for (const auto& [formulation, integrator] : kinds) {
    Params params = bar(averaging(), full_bushing());
    params.formulation = formulation;
    params.integrator = integrator;
    params.integrator.newton_steps = 50;
    params.integrator.newton_tolerance = 1e-12;
    EXPECT_LT(jacobian_error(params, 2, 2e-4), 5e-6)
        << static_cast<int>(formulation) << ' ' << static_cast<int>(integrator.kind);
  }
}

}  // namespace
}  // namespace tandem::fem
