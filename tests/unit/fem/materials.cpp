#include "fem_process/material/materials.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "fem_process/elements/make_formulation.h"
#include "fem_process/transient/static_analysis.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

constexpr FormulationKind kAll[] = {FormulationKind::Linear, FormulationKind::Corotational,
                                    FormulationKind::ConsistentCorotational,
                                    FormulationKind::TotalLagrangian};

/// A carbon-fibre ply (GPa values of a data sheet), fibres along axis 1.
Material ply(const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity()) {
  Material material{.density_kg_per_m3 = 1600.0};
  material.orthotropic = {.young_Pa = {1.4e11, 1.0e10, 0.9e10},
                          .poisson = {0.3, 0.28, 0.45},
                          .shear_Pa = {5e9, 4.5e9, 3.5e9},
                          .axes = axes};
  return material;
}

/// The unit vectors' permutation that puts material axis `axis` along x.
Eigen::Matrix3d axis_along_x(int axis) {
  Eigen::Matrix3d axes;
  for (int k = 0; k < 3; ++k) axes.col((axis + k) % 3) = Eigen::Vector3d::Unit(k);
  return axes;
}

// Uniaxial stress σ along each material axis: the strains are σ/E_i and −ν_ij σ/E_i by the
// definition of the constants.
TEST(FemMaterials, UniaxialStressHasTheStrainsThatDefineTheConstants) {
  const Orthotropic o = *ply().orthotropic;
  const double nu[3][3] = {{-1.0, 0.3, 0.28},
                           {0.3 * 1.0e10 / 1.4e11, -1.0, 0.45},
                           {0.28 * 0.9e10 / 1.4e11, 0.45 * 0.9e10 / 1.0e10, -1.0}};
  const Matrix6d D = elasticity(ply());
  for (int i = 0; i < 3; ++i) {
    Eigen::Matrix<double, 6, 1> strain = Eigen::Matrix<double, 6, 1>::Zero();
    for (int j = 0; j < 3; ++j) strain(j) = -nu[i][j] / o.young_Pa(i);
    const Eigen::Matrix<double, 6, 1> stress = D * strain;
    for (int j = 0; j < 6; ++j) EXPECT_NEAR(stress(j), i == j ? 1.0 : 0.0, 1e-14) << i << j;
  }
  EXPECT_EQ(D(3, 3), 5e9);    // xy: 12
  EXPECT_EQ(D(4, 4), 3.5e9);  // yz: 23
  EXPECT_EQ(D(5, 5), 4.5e9);  // zx: 13
}

// Off-axis modulus of a ply: 1/E_x = c⁴/E_1 + (1/G_12 − 2 ν_12/E_1) s² c² + s⁴/E_2.
TEST(FemMaterials, OffAxisModulusHasItsClosedForm) {
  for (double angle : {0.3, 0.8, 1.4}) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const Matrix6d D = elasticity(ply(rotation({0, 0, angle}).toRotationMatrix()));
    const double expected = std::pow(c, 4) / 1.4e11 + (1 / 5e9 - 2 * 0.3 / 1.4e11) * s * s * c * c +
                            std::pow(s, 4) / 1.0e10;
    EXPECT_NEAR(D.inverse()(0, 0), expected, 1e-12 * expected);
  }
}

// With E, ν and G = E/2(1 + ν) along all axes, however turned: the isotropic matrix.
TEST(FemMaterials, EqualConstantsAreIsotropicInAnyAxes) {
  const Material isotropic{.young_Pa = 5e6, .poisson = 0.3};
  Material same = isotropic;
  same.orthotropic = {.young_Pa = Eigen::Vector3d::Constant(5e6),
                      .poisson = Eigen::Vector3d::Constant(0.3),
                      .shear_Pa = Eigen::Vector3d::Constant(5e6 / 2.6),
                      .axes = rotation({0.4, -0.7, 1.1}).toRotationMatrix()};
  EXPECT_LT((elasticity(same) - elasticity(isotropic)).cwiseAbs().maxCoeff(), 1e-14 * 5e6 * 4);
}

// Isotropic in the plane 23: turning about axis 1 changes nothing.
TEST(FemMaterials, TransverseIsotropyIsBlindToTurnsAboutItsAxis) {
  Material fibre = ply();
  fibre.orthotropic->young_Pa = {1.4e11, 1e10, 1e10};
  fibre.orthotropic->poisson = {0.3, 0.3, 0.4};
  fibre.orthotropic->shear_Pa = {5e9, 5e9, 1e10 / 2.8};
  const Matrix6d straight = elasticity(fibre);
  fibre.orthotropic->axes = rotation({0.9, 0, 0}).toRotationMatrix();
  EXPECT_LT((elasticity(fibre) - straight).cwiseAbs().maxCoeff(), 1e-14 * 1.5e11);
}

/// Forces on the end faces of the bar 0.5 m × 0.05 m × 0.05 m (A = 2.5e-3 m²) when it is strained
/// as a uniaxial stress along x strains it.
Eigen::Vector3d end_force(const TetMesh& mesh, FormulationKind kind, const Material& material,
                          double stress) {
  Eigen::Matrix<double, 6, 1> sigma = Eigen::Matrix<double, 6, 1>::Zero();
  sigma(0) = stress;
  const Eigen::Matrix<double, 6, 1> e = elasticity(material).inverse() * sigma;
  Eigen::Matrix3d strain;
  strain << e(0), e(3) / 2, e(5) / 2, e(3) / 2, e(1), e(4) / 2, e(5) / 2, e(4) / 2, e(2);
  Eigen::VectorXd x(3 * mesh.nodes());
  for (int i = 0; i < mesh.nodes(); ++i) {
    const Eigen::Vector3d& X = mesh.X[static_cast<std::size_t>(i)];
    x.segment<3>(3 * i) = X + strain * X;
  }
  Eigen::VectorXd f;
  BlockValues K;
  make_formulation(kind, mesh, material)->evaluate(x, f, K);
  const std::vector<int>& right = find_set(mesh, {.name = "right"}).nodes;
  const std::vector<int>& left = find_set(mesh, {.name = "left"}).nodes;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (int i : right) force += f.segment<3>(3 * i);
  // No force anywhere but on the end faces.
  double elsewhere = 0.0;
  for (int i = 0; i < mesh.nodes(); ++i) {
    const bool end = std::binary_search(right.begin(), right.end(), i) ||
                     std::binary_search(left.begin(), left.end(), i);
    if (!end) elsewhere = std::max(elsewhere, f.segment<3>(3 * i).norm());
  }
  EXPECT_LT(elsewhere, 1e-6 * std::abs(stress) * 2.5e-3);
  return force;
}

// The uniaxial bar in each material axis and in turned axes, both orders, all formulations: the end
// force is σ A. The strain of 1e-8 leaves as much of the nonlinear ones; rounding of positions
// counts for ε X/(1e-8 l_e) = 2e-7 of the strain, and across the fibres as 14 times as much stress.
TEST(FemMaterials, UniaxialBarsCarryTheirStressInEveryMaterialAxis) {
  std::vector<Eigen::Matrix3d> axes;
  for (int k = 0; k < 3; ++k) axes.push_back(axis_along_x(k));
  axes.push_back(rotation({0.4, -0.7, 1.1}).toRotationMatrix());
  for (int order : {1, 2}) {
    const TetMesh mesh = read_mesh({.file = data_file("bar.msh"), .order = order});
    for (FormulationKind kind : kAll) {
      for (std::size_t k = 0; k < axes.size(); ++k) {
        const double young = k < 3 ? ply().orthotropic->young_Pa(static_cast<Eigen::Index>(k))
                                   : 1.0 / elasticity(ply(axes[k])).inverse()(0, 0);
        const double stress = 1e-8 * young;
        const Eigen::Vector3d force = end_force(mesh, kind, ply(axes[k]), stress);
        EXPECT_LT((force - Eigen::Vector3d(stress * 2.5e-3, 0, 0)).norm(), 1e-6 * stress * 2.5e-3);
      }
    }
  }
}

/// Two unit cubes in a row along x, clamped at x = 0, a force F pulling at x = 2; sets FIRST and
/// SECOND of six tets each.
Params two_cubes(int order, const Material& first, const Material& second) {
  Params params;
  params.mesh.file =
      temporary_file("two.inp", box_inp(2) +
                                    "*ELSET, ELSET=FIRST, GENERATE\n1, 6\n*ELSET, ELSET=SECOND, "
                                    "GENERATE\n7, 12\n");
  params.mesh.order = order;
  params.materials = {{{"FIRST"}, first}, {{"SECOND"}, second}};
  params.micro_step = SimTime(1'000'000);
  params.fixed = {{"LEFT"}};
  params.loads = {{.kind = Load::Kind::SurfaceForce, .set = {"END"}, .value = {30.0, 0, 0}}};
  return params;
}

// Springs in series. With ν = 0 the clamp does not disturb the uniaxial state: u = F/E_1 + F/E_2
// exactly, in the linear formulation and, P = E (λ − 1), in the co-rotational one at 10 % strain.
// Elasticity 1 is given as orthotropic in turned axes.
TEST(FemMaterials, BarOfTwoMaterialsIsTwoSpringsInSeries) {
  Material first{.density_kg_per_m3 = 500.0};
  first.orthotropic = {.young_Pa = {100.0, 300.0, 200.0},
                       .poisson = Eigen::Vector3d::Zero(),
                       .shear_Pa = {40.0, 60.0, 80.0},
                       .axes = axis_along_x(1)};
  const Material second{.young_Pa = 1000.0, .poisson = 0.0, .density_kg_per_m3 = 2000.0};
  for (int order : {1, 2}) {
    for (FormulationKind kind : {FormulationKind::Linear, FormulationKind::Corotational,
                                 FormulationKind::ConsistentCorotational}) {
      Params params = two_cubes(order, first, second);
      params.formulation = kind;
      const Model model(params);
      const StaticResult result =
          StaticAnalysis(model, {.load_factors = {1.0}, .tolerance = 1e-12}).run();
      ASSERT_EQ(result.report.outcome, Outcome::Done) << result.report.message;
      const Eigen::Vector3d u = mean_displacement(model, {"RIGHT"}, result.steps[0].x);
      EXPECT_LT((u - Eigen::Vector3d(30.0 / 300.0 + 30.0 / 1000.0, 0, 0)).norm(), 1e-10);
    }
  }
}

TEST(FemMaterials, EveryMaterialHasItsDensity) {
  for (int order : {1, 2}) {
    const Model model(
        two_cubes(order, {.density_kg_per_m3 = 500.0}, {.density_kg_per_m3 = 2000.0}));
    double sum = 0.0;
    for (double m : model.mass) sum += m;
    EXPECT_NEAR(sum, 2500.0, 1e-9);
  }
}

std::string refusal(const Params& params) {
  try {
    const Model model(params);
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), 2);
    return error.what();
  }
  return "accepted";
}

TEST(FemMaterialDefects, ElementsWithoutMaterialAreNamed) {
  Params params = two_cubes(1, {}, {});
  params.materials.pop_back();
  EXPECT_NE(refusal(params).find("6 of 12 elements"), std::string::npos) << refusal(params);
  EXPECT_NE(refusal(params).find("have no material: 7, 8, 9, 10, 11, 12."), std::string::npos);
}

TEST(FemMaterialDefects, ElementsWithTwoMaterialsAreNamed) {
  Params params = two_cubes(1, {}, {});
  params.materials[1].set.name = "ALL";
  EXPECT_NE(
      refusal(params).find("6 element(s) of 'ALL' have a material of 'FIRST' already: 1, 2, 3, "
                           "4, 5, 6."),
      std::string::npos)
      << refusal(params);
}

TEST(FemMaterialDefects, SetsWithoutElementsAreRefused) {
  Params params = two_cubes(1, {}, {});
  params.materials[1].set.name = "END";
  EXPECT_NE(refusal(params).find("'END' has no tetrahedra"), std::string::npos) << refusal(params);
}

TEST(FemMaterialDefects, NegativeStrainEnergyIsRefused) {
  const auto defect = [](auto spoil) {
    Material material = ply();
    spoil(*material.orthotropic);
    return defect_of(material);
  };
  EXPECT_EQ(defect([](Orthotropic&) {}), "");
  // ν_21 of a data sheet taken for ν_12 of axes that are swapped.
  EXPECT_NE(defect([](Orthotropic& o) {
              o.young_Pa = {1e10, 1.4e11, 1e10};
            }).find("nu_12 = 0.3"),
            std::string::npos);
  EXPECT_NE(defect([](Orthotropic& o) {
              o.poisson = {0.3, 0.28, 1.1};
            }).find("sqrt(E_2/E_3)"),
            std::string::npos);
  // Each pair is good, the three together are not: with equal moduli and ν = 0.6,
  // 1 − 3 · 0.36 − 2 · 0.216 < 0.
  EXPECT_NE(defect([](Orthotropic& o) {
              o.young_Pa.setConstant(1e9);
              o.poisson.setConstant(0.6);
            }).find("must be positive. Take smaller ratios."),
            std::string::npos);
  EXPECT_NE(defect([](Orthotropic& o) { o.shear_Pa(1) = 0.0; }), "");
  EXPECT_NE(defect([](Orthotropic& o) { o.young_Pa(2) = -1.0; }), "");
  EXPECT_NE(defect([](Orthotropic& o) { o.axes *= 2.0; }), "");
  // The criterion is that of the matrix: what is accepted is positive definite.
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(elasticity(ply())).eigenvalues()(0), 0.0);
}

}  // namespace
}  // namespace tandem::fem
