// Static bending of ANCF beams against the tables of an independent program and closed forms.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem_process/ancf/beam_params.h"
#include "tests/support/ancf_support.h"

namespace tandem::fem::ancf {
namespace {

using testing::number;
using testing::read_rows;
using testing::Row;
using testing::straight_beam;

/// Tip deflection (m) of a clamped beam under a dead force at its tip.
Eigen::Vector3d tip_displacement(BeamModel model, double length_m, const Eigen::Vector3d& force_N,
                                 int load_steps) {
  model.loads.push_back(
      {.element = static_cast<int>(model.mesh.elements.size()) - 1, .xi = 1.0, .force_N = force_N});
  const BeamSystem system(std::move(model));
  Eigen::VectorXd q = system.mesh().q0;
  for (int step = 1; step <= load_steps; ++step) {
    const Equilibrium found =
        find_equilibrium(system, 0.0, static_cast<double>(step) / load_steps, 1e-10, 50, q);
    EXPECT_TRUE(found.found) << "load step " << step;
  }
  const int tip = system.mesh().end_position.back();
  return q.segment<3>(3 * tip) - Eigen::Vector3d(length_m, 0.0, 0.0);
}

TEST(AncfStatics, CantileverDeflectionsAreTheTablesOnes) {
  for (const Row& row : read_rows("cantilever_small.csv")) {
    const std::string& law = row.at("law");
    const int elements = std::stoi(row.at("ne"));
    if (elements > 16) continue;  // the finest meshes: below
    const bool svk = law.starts_with("SVK");
    const Integration integration = law == "NH_SRI_vol_axis" ? Integration::VolumeOnAxis
                                    : law == "NH_axis+D0" || law == "SVK_nu_axis"
                                        ? Integration::AxisD0
                                        : Integration::Full;
    const BeamMaterial material =
        BeamMaterial::from_young(svk ? ElasticLaw::SaintVenantKirchhoff : ElasticLaw::NeoHookean,
                                 number(row, "E"), number(row, "nu"));
    const double length = number(row, "L");
    const Eigen::Vector3d tip =
        tip_displacement(straight_beam(length, elements, {number(row, "w"), number(row, "h")},
                                       material, integration),
                         length, {0.0, 0.0, number(row, "F")}, 1);
    // The table has ten digits of a Newton iteration of its own; ν of the track has four or five.
    EXPECT_NEAR(tip.z(), number(row, "uz_tip"),
                (row.at("case").starts_with("track") ? 3e-4 : 2e-6) * std::abs(tip.z()))
        << row.at("case") << " " << law << " " << elements;
  }
}

TEST(AncfStatics, LockingOfFullIntegrationFollowsItsLaw) {
  // Slender: (1 − 1/(4 n²)) of the curvature, (1 + ν)(1 − 2ν)/(1 − ν) of the constrained modulus.
  const double nu = 0.3;
  const double poisson = (1.0 + nu) * (1.0 - 2.0 * nu) / (1.0 - nu);
  const double inertia = std::pow(0.02, 4) / 12.0;
  for (int n : {1, 4, 16, 64}) {
    const BeamMaterial material = BeamMaterial::from_young(ElasticLaw::NeoHookean, 2e8, nu);
    for (const Integration integration : {Integration::Full, Integration::AxisD0}) {
      const double ratio =
          tip_displacement(straight_beam(1.0, n, {0.02, 0.02}, material, integration), 1.0,
                           {0.0, 0.0, -8e-4}, 1)
              .z() /
          (-8e-4 / (3.0 * 2e8 * inertia));
      const double expected =
          (1.0 - 0.25 / (n * n)) * (integration == Integration::Full ? poisson : 1.0);
      // Shear adds 3 E I / (k G A L²) ≈ 3e-4, the clamped lateral gradients a little more.
      EXPECT_NEAR(ratio, expected, 1e-3) << n;
    }
  }
}

TEST(AncfStatics, LargeDeflectionsAreTheTablesOnes) {
  // SVK, ν = 0, L/h = 50: F L²/EI = 1 and 3.
  std::ifstream csv(std::string(TANDEM_SOURCE_DIR) + "/tests/data/ancf/cantilever_large.csv");
  std::string line;
  std::getline(csv, line);
  int compared = 0;
  while (std::getline(csv, line)) {
    std::stringstream text(line);
    std::vector<std::string> field(5);
    for (std::string& f : field) std::getline(text, f, ',');
    const int elements = std::stoi(field[2]);
    if (field[0] != "SVK_full" || elements > 32) continue;
    const BeamMaterial material =
        BeamMaterial::from_young(ElasticLaw::SaintVenantKirchhoff, 2e8, 0.0);
    const double inertia = std::pow(0.02, 4) / 12.0;
    BeamModel model = straight_beam(1.0, elements, {0.02, 0.02}, material);
    model.order = {5, 3, 3};  // St. Venant-Kirchhoff has y⁴: the table integrates it exactly
    const Eigen::Vector3d tip =
        tip_displacement(std::move(model), 1.0, {0.0, 0.0, std::stod(field[1]) * 2e8 * inertia}, 8);
    EXPECT_NEAR(tip.z(), std::stod(field[3]), 2e-7) << line;
    EXPECT_NEAR(tip.x(), std::stod(field[4]), 2e-7) << line;
    ++compared;
  }
  EXPECT_EQ(compared, 10);
}

TEST(AncfStatics, FineBeamsBendAsTheElastica) {
  // Bisshopp & Drucker (1945): F L²/EI = 1 gives u_z/L = 0.30172, u_x/L = −0.05643.
  const BeamMaterial material =
      BeamMaterial::from_young(ElasticLaw::SaintVenantKirchhoff, 2e8, 0.0);
  const double inertia = std::pow(0.02, 4) / 12.0;
  const Eigen::Vector3d tip = tip_displacement(straight_beam(1.0, 32, {0.02, 0.02}, material), 1.0,
                                               {0.0, 0.0, 2e8 * inertia}, 8);
  // What 32 elements and the shear of L/h = 50 leave.
  EXPECT_NEAR(tip.z(), 0.30172, 5e-5);
  EXPECT_NEAR(tip.x(), -0.05643, 5e-5);
}

TEST(AncfStatics, ClosedRingInItsStressFreeShapeIsAtRest) {
  const LoopPath ring{.radius1_m = 0.5, .radius2_m = 0.5};
  BeamModel model{.mesh = join(lay(ring, {.elements = 12, .curved_reference = true})),
                  .section = {0.02, 0.02},
                  .material = BeamMaterial::from_young(ElasticLaw::NeoHookean, 2e8, 0.3)};
  const BeamSystem system(std::move(model));
  ElementArrays elements = system.element_arrays();
  system.kernel().forces(system.mesh().q0, Eigen::VectorXd::Zero(system.mesh().unknowns()),
                         elements);
  for (double f : elements.force) EXPECT_LT(std::abs(f), 1e-8);
}

TEST(AncfStatics, PinchedRingFlattensByTheClosedForm) {
  // Half of a thin ring under two opposite forces F: the quarter points close by
  // (π/4 − 2/π) F R³/(E I) [Timoshenko, Strength of Materials II]. Here: clamped at φ = 0 and
  // pulled at φ = π, where symmetry holds the slope, so the distance of the two grows by that
  // value.
  const double radius = 0.5;
  const double young = 2e8;
  const double inertia = std::pow(0.01, 4) / 12.0;
  const double force = 1e-3;
  const int n = 128;
  const LoopPath ring{.radius1_m = radius, .radius2_m = radius};
  BeamModel model{
      .mesh = join(lay(ring, {.elements = n, .curved_reference = true})),
      .section = {0.01, 0.01},
      .material = BeamMaterial::from_young(ElasticLaw::SaintVenantKirchhoff, young, 0.0)};
  // Holds the first node whole: twelve of the shared coordinates.
  for (const Term& term : model.mesh.elements.front().terms) {
    if (term.slot < 4) model.mesh.fixed[static_cast<std::size_t>(term.vector)] = true;
  }
  const int opposite = model.mesh.end_position[static_cast<std::size_t>(n)];
  const Eigen::Vector3d start = model.mesh.q0.segment<3>(3 * opposite);
  const Eigen::Vector3d along =
      (start - model.mesh.q0.segment<3>(3 * model.mesh.end_position[0])).normalized();
  model.loads.push_back({.element = n / 2, .xi = 0.0, .force_N = force * along});
  const BeamSystem system(std::move(model));
  Eigen::VectorXd q = system.mesh().q0;
  ASSERT_TRUE(find_equilibrium(system, 0.0, 1.0, 1e-11, 50, q).found);
  const double growth = (q.segment<3>(3 * opposite) - start).dot(along);
  const double expected = (std::numbers::pi / 4.0 - 2.0 / std::numbers::pi) * force *
                          std::pow(radius, 3) / (young * inertia);
  // Thin curved elements lock, as 1/n⁴ here: 0.26, 0.021, 0.0014 for 32, 64 and 128 of them.
  EXPECT_NEAR(growth, expected, 0.005 * expected);
}

/// A whole ring of radius 0.5 m, 0.05 m wide and 0.02 m thick, in rubber of 1200 kg/m³.
BeamModel ring_of(int elements, const BeamMaterial& material, Integration integration) {
  const LoopPath ring{.radius1_m = 0.5, .radius2_m = 0.5};
  BeamModel model{.mesh = join(lay(ring, {.elements = elements, .curved_reference = true})),
                  .section = {0.05, 0.02},
                  .material = material,
                  .integration = integration};
  model.material.density_kg_per_m3 = 1200.0;
  return model;
}

/// By how much two opposite forces F pull a ring apart that is held at one of them, over the closed
/// form for a thin one, (π/4 − 2/π) F R³/(E I).
double pulled_apart(BeamModel model) {
  const int n = static_cast<int>(model.mesh.elements.size());
  const double inertia = 0.05 * std::pow(0.02, 3) / 12.0;
  const double expected_m = 1e-5;
  const double force_N = expected_m * model.material.young_Pa() * inertia /
                         ((std::numbers::pi / 4.0 - 2.0 / std::numbers::pi) * std::pow(0.5, 3));
  // Not r_z: the thickness there is free.
  for (const Term& term : model.mesh.elements.front().terms) {
    if (term.slot < 3) model.mesh.fixed[static_cast<std::size_t>(term.vector)] = true;
  }
  const int first = model.mesh.end_position[0];
  const int opposite = model.mesh.end_position[static_cast<std::size_t>(n)];
  const Eigen::Vector3d start = model.mesh.q0.segment<3>(3 * opposite);
  const Eigen::Vector3d along =
      (start - Eigen::Vector3d(model.mesh.q0.segment<3>(3 * first))).normalized();
  model.loads.push_back({.element = n / 2, .xi = 0.0, .force_N = force_N * along});
  const BeamSystem system(std::move(model));
  Eigen::VectorXd q = system.mesh().q0;
  EXPECT_TRUE(find_equilibrium(system, 0.0, 1.0, 1e-12, 100, q).found);
  return (Eigen::Vector3d(q.segment<3>(3 * opposite)) - start).dot(along) / expected_m;
}

// The warning says of which part rings are too stiff, and how many elements are enough.
TEST(AncfStatics, LockingOfBentElementsIsWarnedOfWithTheElementsThatAreEnough) {
  const BeamMaterial rubber = BeamMaterial::from_young(ElasticLaw::SaintVenantKirchhoff, 2e6, 0.0);
  for (const int n : {16, 24, 32}) {
    const BeamModel model = ring_of(n, rubber, Integration::Full);
    const double theta = 2.0 * std::numbers::pi / n;
    const double part = std::pow(theta * 0.5 * theta / 0.02, 2) / 10.0;
    // Beside it the one curvature of an element, θ²/12.
    EXPECT_NEAR(1.0 / pulled_apart(model), 1.0 + part, 0.15 * part + theta * theta / 6.0) << n;
    const auto warning = bending_warning(model);
    ASSERT_TRUE(warning.has_value()) << n;
    // 16 (part of 16 over 0.05)^¼ = 37.4: the same number from every mesh.
    EXPECT_NE(warning->find(" 38 elements or more"), std::string::npos) << *warning;
  }
  EXPECT_FALSE(bending_warning(ring_of(38, rubber, Integration::Full)).has_value());
  // Straight ones do not lock, and pins take the bend.
  EXPECT_FALSE(bending_warning(straight_beam(1.0, 4, {0.02, 0.02}, rubber)).has_value());
  const LoopPath ring{.radius1_m = 0.5, .radius2_m = 0.5};
  BeamModel pinned{.mesh = join(lay(ring, {.elements = 16, .joint = Joint::Pin})),
                   .section = {0.05, 0.02},
                   .material = rubber};
  EXPECT_FALSE(bending_warning(pinned).has_value());
}

// Poisson's ratio does not enter the bending of a ring whose sections are free: axis_d0 has to take
// Young's modulus along the band, not along the axes of the world.
TEST(AncfStatics, RingsBornCurvedBendWithYoungsModulusInTheirOwnAxes) {
  for (const double nu : {0.0, 0.3}) {
    const BeamMaterial rubber = BeamMaterial::from_young(ElasticLaw::SaintVenantKirchhoff, 2e6, nu);
    EXPECT_NEAR(pulled_apart(ring_of(64, rubber, Integration::AxisD0)), 1.0, 0.02) << nu;
  }
}

}  // namespace
}  // namespace tandem::fem::ancf
