// Rings of ANCF beams, born curved and bent from straight, against closed forms: what locks in bent
// elements shows here.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem_process/ancf/beam_params.h"
#include "tests/support/ancf_support.h"

namespace tandem::fem::ancf {
namespace {

using std::numbers::pi;
using testing::straight_beam;

constexpr double kRadius_m = 0.5;
constexpr double kWidth_m = 0.05;

struct Ring {
  int elements = 16;
  double radius_over_height = 25.0;
  bool born_curved = true;
  double nu = 0.0;
  Integration integration = Integration::Full;
  Strain strain = Strain::Assumed;

  [[nodiscard]] double height_m() const { return kRadius_m / radius_over_height; }
  [[nodiscard]] double inertia_m4() const { return kWidth_m * std::pow(height_m(), 3) / 12.0; }
  [[nodiscard]] BeamModel model() const {
    const LoopPath path{.radius1_m = kRadius_m, .radius2_m = kRadius_m};
    BeamModel model{
        .mesh = join(lay(path, {.elements = elements, .curved_reference = born_curved})),
        .section = {kWidth_m, height_m()},
        .material = BeamMaterial::from_young(ElasticLaw::SaintVenantKirchhoff, 2e6, nu),
        .integration = integration,
        .strain = strain};
    model.material.density_kg_per_m3 = 1200.0;
    return model;
  }
};

/// Holds the first node but for r_z: the thickness there is free.
void hold_first_node(BeamMesh& mesh) {
  for (const Term& term : mesh.elements.front().terms) {
    if (term.slot < 3) mesh.fixed[static_cast<std::size_t>(term.vector)] = true;
  }
}

/// Tolerance of Newton's iteration: round-off of the stretch over the bending stiffness.
constexpr double kTolerance_m = 2e-10;

/// By how much two opposite forces F pull a ring apart that is held at one of them, over the closed
/// form for a thin one, (π/4 − 2/π) F R³/(E I) [Timoshenko, Strength of Materials II]. A ring bent
/// from a straight bar has the same: its moment E I/R is uniform, and without a normal force it
/// does not enter the equilibrium of small changes.
double pulled_apart(const Ring& ring) {
  BeamModel model = ring.model();
  const double expected_m = 1e-4;
  const double force_N = expected_m * model.material.young_Pa() * ring.inertia_m4() /
                         ((pi / 4.0 - 2.0 / pi) * std::pow(kRadius_m, 3));
  hold_first_node(model.mesh);
  const int first = model.mesh.end_position[0];
  const int opposite = model.mesh.end_position[static_cast<std::size_t>(ring.elements)];
  const Eigen::Vector3d along = (model.mesh.q0.segment<3>(3 * opposite) -
                                 Eigen::Vector3d(model.mesh.q0.segment<3>(3 * first)))
                                    .normalized();
  model.loads.push_back({.element = ring.elements / 2, .xi = 0.0, .force_N = force_N * along});
  const BeamSystem system(std::move(model));
  Eigen::VectorXd q = system.mesh().q0;
  EXPECT_TRUE(find_equilibrium(system, 0.0, 0.0, kTolerance_m, 100, q).found);
  const Eigen::Vector3d start = q.segment<3>(3 * opposite);
  EXPECT_TRUE(find_equilibrium(system, 0.0, 1.0, kTolerance_m, 100, q).found);
  return (Eigen::Vector3d(q.segment<3>(3 * opposite)) - start).dot(along) / expected_m;
}

TEST(AncfRings, ARingInItsStressFreeShapeIsAtRest) {
  for (const Strain strain : {Strain::Assumed, Strain::Compatible}) {
    const BeamSystem system(Ring{.elements = 12, .nu = 0.3, .strain = strain}.model());
    ElementArrays elements = system.element_arrays();
    system.kernel().forces(system.mesh().q0, Eigen::VectorXd::Zero(system.mesh().unknowns()),
                           elements);
    for (double f : elements.force) EXPECT_LT(std::abs(f), 1e-8);
    EXPECT_LT(std::abs(system.elastic_J(system.mesh().q0)), 1e-15);
  }
}

// What is left at any thickness is no locking but the one curvature of an element, and falls as
// 1/n². That makes rings stiffer, and the sine of an element's angle in place of the angle makes
// them softer: the two nearly cancel where the curvature counts from that of birth, and the second
// is twice as large where it counts from zero. With compatible strains born rings of 16 elements
// have 0.40, 0.041 and 0.003 of their deflection.
TEST(AncfRings, PulledRingsDeflectByTheClosedFormAtAnyThickness) {
  for (const bool born_curved : {true, false}) {
    for (const double slenderness : {25.0, 100.0, 400.0}) {
      const auto of = [&](int n) {
        return pulled_apart(
            {.elements = n, .radius_over_height = slenderness, .born_curved = born_curved});
      };
      const std::string where =
          (born_curved ? "born curved, " : "bent, ") + std::to_string(slenderness);
      const double coarse = of(16);
      const double fine = of(32);
      // Stretch and shear of a thick ring add (h/R)² of about one to the closed form, and to that
      // of the bent one what its strains of h/(2R) do.
      const double thick = (born_curved ? 2.0 : 4.0) / (slenderness * slenderness);
      // θ²/8 and θ²/3 of the 16 elements' θ = 0.39.
      EXPECT_NEAR(coarse, 1.0, (born_curved ? 0.020 : 0.052) + thick) << where;
      EXPECT_NEAR(fine, 1.0, (born_curved ? 0.005 : 0.013) + thick) << where;
      // Richardson: what second order leaves at n → ∞.
      EXPECT_NEAR(fine + (fine - coarse) / 3.0, 1.0, 1e-3 + thick) << where;
    }
  }
}

// Poisson's ratio does not enter the bending of a ring whose sections are free: axis_d0 has to take
// Young's modulus along the band, not along the axes of the world. The whole law in every point
// bends with the constrained modulus.
TEST(AncfRings, BendWithTheModulusOfTheirIntegration) {
  const double nu = 0.3;
  const double poisson = (1.0 + nu) * (1.0 - 2.0 * nu) / (1.0 - nu);
  for (const bool born_curved : {true, false}) {
    const int n = born_curved ? 16 : 64;
    EXPECT_NEAR(pulled_apart({.elements = n,
                              .born_curved = born_curved,
                              .nu = nu,
                              .integration = Integration::AxisD0}),
                1.0, 0.02);
    EXPECT_NEAR(pulled_apart({.elements = n, .born_curved = born_curved, .nu = nu}), poisson,
                0.02 * poisson);
  }
  EXPECT_NEAR(pulled_apart({.elements = 64,
                            .nu = nu,
                            .integration = Integration::AxisD0,
                            .strain = Strain::Compatible}),
              1.0, 0.02);
}

// A straight bar of length 2πR closed to a ring holds ½ E I/R² per length.
TEST(AncfRings, BarsBentToARingHoldTheEnergyOfPureBending) {
  for (const double slenderness : {25.0, 400.0}) {
    const Ring ring{.radius_over_height = slenderness, .born_curved = false};
    BeamModel model = ring.model();
    hold_first_node(model.mesh);
    const double expected = pi * model.material.young_Pa() * ring.inertia_m4() / kRadius_m;
    const BeamSystem system(std::move(model));
    Eigen::VectorXd q = system.mesh().q0;
    ASSERT_TRUE(find_equilibrium(system, 0.0, 1.0, kTolerance_m, 100, q).found);
    // r_x·∂r_z/∂x is sin θ/θ of the curvature at the nodes and 1 − θ²/24 of it between them.
    EXPECT_NEAR(system.elastic_J(q), expected, 0.05 * expected) << slenderness;
  }
}

TEST(AncfRings, APathGivesTheRingItsMass) {
  // 2π R A ρ, but for what the cubics between points of a circle are shorter than the arc, θ⁴/720.
  for (const int n : {8, 16}) {
    const BeamSystem system(Ring{.elements = n}.model());
    const double expected = 2.0 * pi * kRadius_m * kWidth_m * 0.02 * 1200.0;
    EXPECT_NEAR(system.mass_kg(), expected, 1.2 * std::pow(2.0 * pi / n, 4) / 720.0 * expected);
  }
}

// The warning says of which part rings of compatible strains are too stiff, and how many elements
// are enough.
TEST(AncfRings, LockingOfCompatibleStrainsIsWarnedOfWithTheElementsThatAreEnough) {
  for (const int n : {16, 24, 32}) {
    const Ring ring{.elements = n, .strain = Strain::Compatible};
    const double theta = 2.0 * pi / n;
    const double part = std::pow(theta * 0.5 * theta / 0.02, 2) / 10.0;
    // Beside it the one curvature of an element, θ²/12.
    EXPECT_NEAR(1.0 / pulled_apart(ring), 1.0 + part, 0.15 * part + theta * theta / 6.0) << n;
    const auto warning = bending_warning(ring.model());
    ASSERT_TRUE(warning.has_value()) << n;
    // 16 (part of 16 over 0.05)^¼ = 37.4: the same number from every mesh.
    EXPECT_NE(warning->find(" 38 elements or more"), std::string::npos) << *warning;
    EXPECT_NE(warning->find("strain: assumed"), std::string::npos) << *warning;
    EXPECT_FALSE(bending_warning(Ring{.elements = n}.model()).has_value());
  }
  const Ring enough{.elements = 38, .strain = Strain::Compatible};
  EXPECT_FALSE(bending_warning(enough.model()).has_value());
  // Straight ones do not lock, and pins take the bend.
  BeamModel straight = straight_beam(1.0, 4, {0.02, 0.02}, enough.model().material);
  straight.strain = Strain::Compatible;
  EXPECT_FALSE(bending_warning(straight).has_value());
  BeamModel pinned = enough.model();
  const LoopPath path{.radius1_m = kRadius_m, .radius2_m = kRadius_m};
  pinned.mesh = join(lay(path, {.elements = 16, .joint = Joint::Pin}));
  EXPECT_FALSE(bending_warning(pinned).has_value());
}

}  // namespace
}  // namespace tandem::fem::ancf
