// Micro steps of the flexible side: how far a rigid body on its port stiffness may outrun them.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

const SimTime kMacro(8'000'000);

/// A massless box, held at one face, with a port on the other.
Params spring_with(int micro_steps) {
  Params params;
  params.mesh.file = temporary_file("micro_steps.inp", box_inp(2));
  params.material = {.young_Pa = 300.0, .poisson = 0.3, .density_kg_per_m3 = 1e-9};
  params.formulation = FormulationKind::Linear;
  params.fixed = {{"LEFT"}};
  params.ports = {{"right", {"RIGHT"}, std::nullopt, {}}};
  params.micro_step = kMacro / micro_steps;
  return params;
}

MotionSet motion(double x, double v) {
  MotionSet motions(1);
  motions[0].p_WP.x() = x;
  motions[0].v_WP.x() = v;
  return motions;
}

/// Force of the spring over one macro step.
double force(FlexibleBody& body, double x, double v, double x_next, double v_next) {
  return body.advance(request(motion(x, v), motion(x_next, v_next), kMacro)).output[0].f_P_W.x();
}

/// Largest excursion after 400 macro steps of a mass on the spring, semi-implicit Euler with the
/// force at the end: m (v⁺ − v) = H λ(x + H v⁺, v⁺), λ affine. It starts from 1 mm.
double excursion(int micro_steps, double stiffness_by_mass_H2) {
  FlexibleBody body(spring_with(micro_steps));
  const double H = to_seconds(kMacro);
  body.initialize(motion(0.0, 0.0));
  body.checkpoint();
  force(body, 0.0, 0.0, 1e-3, 0.0);
  const double stiffness = -force(body, 1e-3, 0.0, 1e-3, 0.0) / 1e-3;
  body.rollback();
  const double m = stiffness * H * H / stiffness_by_mass_H2;
  double x = 1e-3, v = 0.0, largest = 0.0;
  force(body, 0.0, 0.0, x, 0.0);
  for (int n = 0; n < 400; ++n) {
    body.checkpoint();
    const double at_0 = force(body, x, v, x, 0.0);
    body.rollback();
    const double at_1 = force(body, x, v, x + H * 1.0, 1.0);
    body.rollback();
    const double v_next = (m * v + H * at_0) / (m - H * (at_1 - at_0));
    force(body, x, v, x + H * v_next, v_next);
    x += H * v_next;
    v = v_next;
    if (n >= 350) largest = std::max(largest, std::abs(x));
  }
  return largest;
}

// In the mean over n micro steps the spring sees the port at x + H (θ₀ v + θ₁ v⁺), by the Hermite
// positions at their beginnings and the linear velocities at their ends, and the recursion has an
// eigenvalue of −1 at k H²/m = 4/(1 − 2 (θ₁ − θ₀)):
//   θ₁ − θ₀ = 4 S₂ − 2 S₃ − S₁ + 1/n²,   S_i = 1/n Σ ((j − 1)/n)^i.
// One step, θ₁ = 1, is stable for all.
TEST(FemMicroSteps, AreStableWhileTheMacroStepResolvesARigidBodyOnThePort) {
  EXPECT_LT(excursion(1, 1e3), 1e-3);
  for (const int n : {2, 4, 8}) {
    double S[4] = {};
    for (int j = 0; j < n; ++j) {
      for (int i = 1; i < 4; ++i) S[i] += std::pow(j / static_cast<double>(n), i) / n;
    }
    const double limit = 4.0 / (1.0 - 2.0 * (4.0 * S[2] - 2.0 * S[3] - S[1] + 1.0 / (n * n)));
    EXPECT_LT(excursion(n, 0.9 * limit), 1e-3) << n << " micro steps, limit " << limit;
    EXPECT_GT(excursion(n, 1.1 * limit), 1.0) << n << " micro steps, limit " << limit;
  }
}

}  // namespace
}  // namespace tandem::fem
