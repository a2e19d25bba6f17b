#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <tuple>

#include "fem_process/ancf/beam_modes.h"
#include "fem_process/kernels/simd.h"
#include "tests/support/ancf_support.h"

namespace tandem::fem::ancf {
namespace {

using testing::kTrackSection;
using testing::track_rubber;

Eigen::MatrixXd tangent_of(const BeamKernel& kernel, const Eigen::VectorXd& q,
                           const Eigen::VectorXd& v, double theta) {
  ElementArrays out{std::vector<double>(kCoordinates),
                    std::vector<double>(kCoordinates * kCoordinates)};
  EXPECT_EQ(kernel.tangents(q, v, theta, out), 0);
  return Eigen::Map<const Eigen::Matrix<double, kCoordinates, kCoordinates, Eigen::RowMajor>>(
      out.tangent.data());
}

Eigen::VectorXd force_of(const BeamKernel& kernel, const Eigen::VectorXd& q,
                         const Eigen::VectorXd& v) {
  ElementArrays out{std::vector<double>(kCoordinates), {}};
  EXPECT_EQ(kernel.forces(q, v, out), 0);
  return Eigen::Map<const Eigen::VectorXd>(out.force.data(), kCoordinates);
}

/// Reproducible numbers in [−1, 1] without a pattern.
Eigen::VectorXd wobble(Eigen::Index n, double seed) {
  Eigen::VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) x(i) = std::sin(seed + 12.9898 * static_cast<double>(i * i));
  return x;
}

/// One track element whose unknowns are its own 24 coordinates, in their order.
BeamMesh one_element(bool curved = false) {
  if (!curved) return join(lay(LinePath{.length_m = 0.12}, {.elements = 1}));
  const LoopPath ring{.radius1_m = 0.3, .radius2_m = 0.3};
  Chain chain = lay(ring, {.elements = 6, .curved_reference = true});
  chain.ends.resize(2);
  chain.lengths_m.resize(1);
  chain.closed = false;
  return join(chain);
}

struct Case {
  const char* name;
  ElasticLaw law;
  Integration integration;
  Viscosity viscosity;
  bool curved;
};

class AncfTangent : public ::testing::TestWithParam<std::tuple<Case, Strain>> {
 protected:
  static const Case& which() { return std::get<Case>(GetParam()); }
  static BeamKernel kernel_of(const BeamMesh& mesh, const BeamMaterial& material) {
    return {mesh,
            kTrackSection,
            rule_laws(material, which().integration),
            {},
            std::get<Strain>(GetParam())};
  }
};

TEST_P(AncfTangent, IsTheDerivativeOfTheForces) {
  BeamMaterial material = track_rubber();
  material.law = which().law;
  material.viscosity = which().viscosity;
  // Makes the viscous part as large as the elastic one at the rates below.
  material.dilatation_s = material.deviation_s = 0.02;
  const BeamMesh mesh = one_element(which().curved);
  const BeamKernel kernel = kernel_of(mesh, material);
  const Eigen::VectorXd q =
      mesh.q0 +
      0.05 * wobble(kCoordinates, 1.0)
                 .cwiseProduct(mesh.q0.cwiseAbs() + Eigen::VectorXd::Constant(kCoordinates, 0.02));
  const Eigen::VectorXd v = 0.5 * wobble(kCoordinates, 2.0);

  const Eigen::MatrixXd K = tangent_of(kernel, q, v, 0.0);
  // The tangent is affine in θ: its derivative is that of the forces with respect to the rates.
  const double theta = 50.0;
  const Eigen::MatrixXd C = (tangent_of(kernel, q, v, theta) - K) / theta;
  Eigen::MatrixXd K_differences(kCoordinates, kCoordinates);
  Eigen::MatrixXd C_differences(kCoordinates, kCoordinates);
  const double step = 1e-6;
  for (Eigen::Index j = 0; j < kCoordinates; ++j) {
    const Eigen::VectorXd d = step * Eigen::VectorXd::Unit(kCoordinates, j);
    K_differences.col(j) = (force_of(kernel, q + d, v) - force_of(kernel, q - d, v)) / (2.0 * step);
    C_differences.col(j) = (force_of(kernel, q, v + d) - force_of(kernel, q, v - d)) / (2.0 * step);
  }
  // Central differences: truncation step², round-off ε/step.
  EXPECT_LT((K - K_differences).norm(), 1e-7 * K.norm());
  EXPECT_LT((C - C_differences).norm(), 1e-7 * C.norm());
}

TEST_P(AncfTangent, ElasticForcesAreTheGradientOfTheEnergy) {
  BeamMaterial material = track_rubber();
  material.law = which().law;
  const BeamMesh mesh = one_element(which().curved);
  const BeamKernel kernel = kernel_of(mesh, material);
  const Eigen::VectorXd q =
      mesh.q0 + 0.05 * wobble(kCoordinates, 3.0).cwiseProduct(mesh.q0.cwiseAbs());
  const Eigen::VectorXd f = force_of(kernel, q, Eigen::VectorXd::Zero(kCoordinates));
  const double step = 2e-6;
  for (Eigen::Index j = 0; j < kCoordinates; ++j) {
    const Eigen::VectorXd d = step * Eigen::VectorXd::Unit(kCoordinates, j);
    const double slope = (kernel.energy(q + d) - kernel.energy(q - d)) / (2.0 * step);
    EXPECT_NEAR(f(j), slope, 1e-7 * f.norm()) << "coordinate " << j;
  }
}

TEST_P(AncfTangent, RigidMotionGivesNoForce) {
  BeamMaterial material = track_rubber();
  material.law = which().law;
  material.viscosity = which().viscosity;
  const BeamMesh mesh = one_element(which().curved);
  const BeamKernel kernel = kernel_of(mesh, material);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(2.1, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  const Eigen::Vector3d spin(3.0, -1.0, 2.0);
  Eigen::VectorXd q(kCoordinates);
  Eigen::VectorXd v(kCoordinates);
  for (int slot = 0; slot < kVectors; ++slot) {
    const Eigen::Vector3d shift =
        slot % 4 == 0 ? Eigen::Vector3d(0.3, 0.2, -0.1) : Eigen::Vector3d::Zero();
    q.segment<3>(3 * slot) = R * mesh.q0.segment<3>(3 * slot) + shift;
    v.segment<3>(3 * slot) = spin.cross(q.segment<3>(3 * slot));
  }
  // Stiffness 3e8 Pa times 0.008 m² times round-off.
  EXPECT_LT(force_of(kernel, q, v).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LT(std::abs(kernel.energy(q)), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(
    AllLaws, AncfTangent,
    ::testing::Combine(
        ::testing::Values(
            Case{"full", ElasticLaw::NeoHookean, Integration::Full, Viscosity::Spatial, false},
            Case{"full_green", ElasticLaw::NeoHookean, Integration::Full, Viscosity::Green, false},
            Case{"volume_on_axis", ElasticLaw::NeoHookean, Integration::VolumeOnAxis,
                 Viscosity::Spatial, false},
            Case{"axis_d0", ElasticLaw::NeoHookean, Integration::AxisD0, Viscosity::Spatial, false},
            Case{"svk", ElasticLaw::SaintVenantKirchhoff, Integration::Full, Viscosity::Green,
                 false},
            Case{"svk_axis_d0", ElasticLaw::SaintVenantKirchhoff, Integration::AxisD0,
                 Viscosity::Spatial, false},
            Case{"curved", ElasticLaw::NeoHookean, Integration::Full, Viscosity::Spatial, true},
            Case{"curved_svk", ElasticLaw::SaintVenantKirchhoff, Integration::Full,
                 Viscosity::Green, true},
            Case{"curved_axis_d0", ElasticLaw::NeoHookean, Integration::AxisD0, Viscosity::Spatial,
                 true}),
        ::testing::Values(Strain::Assumed, Strain::Compatible)),
    [](const auto& test) {
      return std::string(std::get<Case>(test.param).name) +
             (std::get<Strain>(test.param) == Strain::Assumed ? "_assumed" : "_compatible");
    });

TEST(AncfElement, MassMatrixIsTheReferenceOne) {
  const auto m = mass_matrix(2000.0, 0.12, kTrackSection);
  std::ifstream csv(std::string(TANDEM_SOURCE_DIR) + "/tests/data/ancf/mass_matrix_8x8.csv");
  std::string line;
  std::getline(csv, line);
  for (int a = 0; a < kVectors; ++a) {
    ASSERT_TRUE(std::getline(csv, line));
    std::stringstream fields(line);
    for (int b = 0; b < kVectors; ++b) {
      std::string field;
      std::getline(fields, field, ',');
      // The table has 13 digits and the round-off of its quadrature for zeros.
      EXPECT_NEAR(m(a, b), std::stod(field), 1e-12 * m(0, 0)) << a << ", " << b;
    }
  }
}

TEST(AncfElement, MassByQuadratureEqualsTheClosedForm) {
  const BeamMesh mesh = one_element();
  const auto closed = mass_matrix(2000.0, 0.12, kTrackSection);
  const auto summed = mass_matrix(2000.0, 0.12, kTrackSection, mesh.gather(0, mesh.q0));
  EXPECT_LT((closed - summed).cwiseAbs().maxCoeff(), 1e-14 * closed.maxCoeff());
}

TEST(AncfElement, CurvedElementsHaveTheMassOfTheirRing) {
  // Pappus: a ring's volume is that of its centre line times the section, as thick between the
  // nodes as there. The cubic between two points of a circle is shorter than the arc by θ⁴/720.
  for (int n : {12, 48}) {
    const LoopPath path{.radius1_m = 0.3, .radius2_m = 0.3};
    const BeamMesh ring = join(lay(path, {.elements = n, .curved_reference = true}));
    const double length = ring.elements.front().length_m;
    const auto m = mass_matrix(2000.0, length, kTrackSection, ring.reference.front());
    const double mass = m(0, 0) + 2.0 * m(0, 4) + m(4, 4);
    const double theta = 2.0 * std::numbers::pi / n;
    EXPECT_NEAR(mass / (2000.0 * length * kTrackSection.area_m2()),
                1.0 - std::pow(theta, 4) / 720.0, 0.1 * std::pow(theta, 4) / 720.0);
  }
}

TEST(AncfElement, ShapeGradientsAreDerivativesOfTheShapeValues) {
  const double l = 0.7;
  const Eigen::Vector3d at(0.31, 0.05, -0.02);
  const auto gradient = shape_gradients(l, at.x(), at.y(), at.z());
  for (int axis = 0; axis < 3; ++axis) {
    const double step = 1e-6;
    const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(axis);
    const auto value = [&](const Eigen::Vector3d& x) {
      return shape_values(l, x.x() / l, x.y(), x.z());
    };
    const Eigen::Vector3d x(l * at.x(), at.y(), at.z());
    const Eigen::VectorXd slope = (value(x + d) - value(x - d)) / (2.0 * step);
    EXPECT_LT((gradient.col(axis) - slope).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(AncfElement, GaussRuleIsExactToItsDegree) {
  for (int n = 1; n <= 8; ++n) {
    const GaussRule rule = gauss_rule(n);
    for (int degree = 0; degree < 2 * n; ++degree) {
      double sum = 0.0;
      for (std::size_t i = 0; i < rule.point.size(); ++i) {
        sum += rule.weight[i] * std::pow(rule.point[i], degree);
      }
      EXPECT_NEAR(sum, 1.0 / (degree + 1), 1e-14) << n << " points, degree " << degree;
    }
  }
}

TEST(AncfElement, UniaxialForceIsTheTablesOne) {
  const BeamMesh mesh = one_element();
  for (const Strain strain : {Strain::Assumed, Strain::Compatible}) {
    const BeamKernel kernel(mesh, kTrackSection, rule_laws(track_rubber(), Integration::Full), {},
                            strain);
    for (const testing::Row& row : testing::read_rows("uniaxial.csv")) {
      const double stretch = testing::number(row, "lambda");
      const double lateral = testing::number(row, "lambda_t");
      Eigen::VectorXd q = mesh.q0;
      for (int slot = 0; slot < kVectors; ++slot) {
        q.segment<3>(3 * slot) *= slot % 4 < 2 ? stretch : lateral;
      }
      const Eigen::VectorXd f = force_of(kernel, q, Eigen::VectorXd::Zero(kCoordinates));
      const double force = testing::number(row, "force_N");
      // r¹ needs −F, r² F. The table's λ_t is rounded at 5e-9: times ∂P/∂λ_t ≈ 2 k and the area,
      // 0.1 N.
      EXPECT_NEAR(f(12), force, 0.1) << stretch;
      EXPECT_NEAR(f(0), -force, 0.1) << stretch;
      // No stress across: what r_y¹ and r_z¹ need belongs to a volume of half the element.
      EXPECT_NEAR(f(7), 0.0, 0.1 * 0.06) << stretch;
      EXPECT_NEAR(f(11), 0.0, 0.1 * 0.06) << stretch;
    }
  }
}

TEST(AncfElement, LateralStretchIsTheTablesOne) {
  for (const testing::Row& row : testing::read_rows("uniaxial.csv")) {
    EXPECT_NEAR(lateral_stretch(track_rubber(), testing::number(row, "lambda")),
                testing::number(row, "lambda_t"), 6e-9);  // eight digits after the point
  }
  // St. Venant-Kirchhoff: the sides contract by ν times Green's strain.
  const BeamMaterial svk = BeamMaterial::from_young(ElasticLaw::SaintVenantKirchhoff, 1e7, 0.3);
  const double across = lateral_stretch(svk, 1.2);
  EXPECT_NEAR(0.5 * (across * across - 1.0), -0.3 * 0.5 * (1.44 - 1.0), 1e-12);
}

TEST(AncfElement, TurnedInsideOutIsReported) {
  const BeamMesh mesh = one_element();
  for (const Strain strain : {Strain::Assumed, Strain::Compatible}) {
    const BeamKernel kernel(mesh, kTrackSection, rule_laws(track_rubber(), Integration::Full), {},
                            strain);
    ElementArrays out{std::vector<double>(kCoordinates), {}};
    // Thickness and width: C, which has no sign, would not tell.
    for (const int slot : {2, 3}) {
      Eigen::VectorXd q = mesh.q0;
      q.segment<3>(3 * slot) *= -1.0;
      EXPECT_EQ(kernel.forces(q, Eigen::VectorXd::Zero(kCoordinates), out), 1);
      q.segment<3>(3 * (slot + 4)) *= -1.0;
      EXPECT_EQ(kernel.forces(q, Eigen::VectorXd::Zero(kCoordinates), out), 1);
    }
    EXPECT_EQ(kernel.forces(mesh.q0, Eigen::VectorXd::Zero(kCoordinates), out), 0);
  }
}

// What the strains and their points leave without stiffness would move on its own.
TEST(AncfElement, FreeChainsHaveSixRigidMotionsAndNoOther) {
  constexpr int kLinks = 3;
  for (const bool curved : {false, true}) {
    const LoopPath ring{.radius1_m = 0.3, .radius2_m = 0.3};
    Chain chain = curved ? lay(ring, {.elements = 16, .curved_reference = true})
                         : lay(LinePath{.length_m = 0.36}, {.elements = kLinks});
    chain.ends.resize(2 * kLinks);
    chain.lengths_m.resize(kLinks);
    chain.closed = false;
    for (const Integration integration : {Integration::Full, Integration::AxisD0}) {
      for (const Strain strain : {Strain::Assumed, Strain::Compatible}) {
        const BeamSystem system({.mesh = join(chain),
                                 .section = {0.05, 0.02},
                                 .material = track_rubber(),
                                 .integration = integration,
                                 .strain = strain});
        const Eigen::VectorXd f =
            eigenfrequencies_Hz(system, system.mesh().q0, system.mesh().unknowns());
        // Round-off of the highest, 1e-8 of it. The lowest bending is the next: 22.4 r/L² √(E/ρ) of
        // some √(36 k/ρ)/h, 2e-3.
        EXPECT_LT(f(5), 1e-6 * f(f.size() - 1));
        EXPECT_GT(f(6), 3e-4 * f(f.size() - 1));
      }
    }
  }
}

TEST(AncfElement, AllVectorUnitsGiveTheSameBits) {
  const LoopPath ring{.radius1_m = 0.3, .radius2_m = 0.3};
  const BeamMesh mesh = join(lay(ring, {.elements = 6, .curved_reference = true}));
  const auto n = static_cast<std::size_t>(6);
  const Eigen::VectorXd q = mesh.q0 + 0.01 * wobble(mesh.unknowns(), 1.0);
  const Eigen::VectorXd v = 0.5 * wobble(mesh.unknowns(), 2.0);
  for (const Strain strain : {Strain::Assumed, Strain::Compatible}) {
    const BeamKernel kernel(mesh, kTrackSection, rule_laws(track_rubber(), Integration::AxisD0), {},
                            strain);
    std::vector<ElementArrays> seen;
    for (const VectorUnit unit : {VectorUnit::Plain, VectorUnit::Avx2, VectorUnit::Avx512}) {
      limit_vector_unit(unit);
      seen.push_back({std::vector<double>(n * kCoordinates),
                      std::vector<double>(n * kCoordinates * kCoordinates)});
      EXPECT_EQ(kernel.tangents(q, v, 100.0, seen.back()), 0);
      EXPECT_EQ(seen.back().force, seen.front().force);
      EXPECT_EQ(seen.back().tangent, seen.front().tangent);
    }
  }
}

}  // namespace
}  // namespace tandem::fem::ancf
