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
    BeamModel model = straight_beam(length, elements, {number(row, "w"), number(row, "h")},
                                    material, integration);
    model.strain = Strain::Compatible;
    const Eigen::Vector3d tip =
        tip_displacement(std::move(model), length, {0.0, 0.0, number(row, "F")}, 1);
    // The table has ten digits of a Newton iteration of its own; ν of the track has four or five.
    EXPECT_NEAR(tip.z(), number(row, "uz_tip"),
                (row.at("case").starts_with("track") ? 3e-4 : 2e-6) * std::abs(tip.z()))
        << row.at("case") << " " << law << " " << elements;
  }
}

// Straight beams under a force at their tip: the curvature is one number per element, which leaves
// 1 − 1/(4 n²) of the deflection of a slender beam, whatever its slenderness: there is no locking
// in shear. Full integration bends with the constrained modulus, (1 + ν)(1 − 2ν)/(1 − ν).
TEST(AncfStatics, StraightBeamsConvergeAsTheirCurvatureDoesWhateverTheSlenderness) {
  const double nu = 0.3;
  const double poisson = (1.0 + nu) * (1.0 - 2.0 * nu) / (1.0 - nu);
  const BeamMaterial material = BeamMaterial::from_young(ElasticLaw::NeoHookean, 2e8, nu);
  for (const double height : {0.02, 0.001}) {
    const double bending = 2e8 * std::pow(height, 4) / 12.0;
    const double tip_m = -1e-5;  // small against the height: no stretch of the clamped line
    const double force = tip_m * 3.0 * bending;
    for (int n : {1, 4, 16, 64}) {
      for (const Integration integration : {Integration::Full, Integration::AxisD0}) {
        for (const Strain strain : {Strain::Assumed, Strain::Compatible}) {
          BeamModel model = straight_beam(1.0, n, {height, height}, material, integration);
          model.strain = strain;
          const double ratio =
              tip_displacement(std::move(model), 1.0, {0.0, 0.0, force}, 1).z() / tip_m;
          const double expected =
              (1.0 - 0.25 / (n * n)) * (integration == Integration::Full ? poisson : 1.0);
          // Shear adds 3 E I / (k G A L²) ≈ 3e-4 at L/h = 50, the clamped lateral gradients a
          // little more.
          EXPECT_NEAR(ratio, expected, 1e-3) << n << " elements, height " << height;
        }
      }
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
    model.strain = Strain::Compatible;
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
  for (const Strain strain : {Strain::Assumed, Strain::Compatible}) {
    BeamModel model = straight_beam(1.0, 32, {0.02, 0.02}, material);
    model.strain = strain;
    const Eigen::Vector3d tip =
        tip_displacement(std::move(model), 1.0, {0.0, 0.0, 2e8 * inertia}, 8);
    // What 32 elements and the shear of L/h = 50 leave; assumed strains also the one curvature per
    // element, 1/(4 n²) of the deflection.
    const double one_curvature = strain == Strain::Assumed ? 0.25 / (32.0 * 32.0) * 0.30172 : 0.0;
    EXPECT_NEAR(tip.z(), 0.30172, 5e-5 + one_curvature);
    EXPECT_NEAR(tip.x(), -0.05643, 5e-5);
  }
}

// With assumed strains four elements are as near as their one curvature each allows, ten times as
// thin a beam too; compatible ones give 0.2514 of 0.3017 there (cantilever_large.csv).
TEST(AncfStatics, CoarseBeamsBendFarAsTheElasticaAtAnyThickness) {
  for (const double height : {0.02, 0.002}) {
    const BeamMaterial material =
        BeamMaterial::from_young(ElasticLaw::SaintVenantKirchhoff, 2e8, 0.0);
    const double bending = 2e8 * std::pow(height, 4) / 12.0;
    for (int n : {4, 8, 16}) {
      const Eigen::Vector3d tip = tip_displacement(
          straight_beam(1.0, n, {height, height}, material), 1.0, {0.0, 0.0, bending}, 8);
      EXPECT_NEAR(tip.z(), 0.30172, (0.5 / (n * n) + 3e-4) * 0.30172) << n << ", " << height;
    }
  }
}

}  // namespace
}  // namespace tandem::fem::ancf
