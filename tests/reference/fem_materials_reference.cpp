// CalculiX 2.20: *ELASTIC, TYPE=ENGINEERING CONSTANTS with *ORIENTATION beside an isotropic
// material, on the cantilever of tests/data/fem cut in two, C3D4 and C3D10.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "fem_process/transient/static_analysis.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_reference_cases.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

/// The cantilever as Abaqus text: *ELSET near (centroid below x = 0.5 m) and far, node sets.
std::string cut_cantilever() {
  const TetMesh mesh = read_mesh({.file = data_file("cantilever_c2.msh")});
  std::string nodes = "*NODE\n";
  std::string elements[] = {"*ELEMENT, TYPE=C3D4, ELSET=near\n",
                            "*ELEMENT, TYPE=C3D4, ELSET=far\n"};
  std::string sets[] = {"*NSET, NSET=fixed\n", "*NSET, NSET=end\n"};
  const auto tag = [&](int node) {
    return std::to_string(mesh.node_tags[static_cast<std::size_t>(node)]);
  };
  for (int i = 0; i < mesh.nodes(); ++i) {
    const Eigen::Vector3d& X = mesh.X[static_cast<std::size_t>(i)];
    char row[128];
    std::snprintf(row, sizeof row, ", %.17g, %.17g, %.17g\n", X.x(), X.y(), X.z());
    nodes += tag(i) + row;
    if (std::abs(X.x()) < 1e-9) sets[0] += tag(i) + "\n";
    if (std::abs(X.x() - 1.0) < 1e-9) sets[1] += tag(i) + "\n";
  }
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    double x = 0.0;
    std::string row = std::to_string(mesh.element_tags[e]);
    for (int node : mesh.tets[e]) {
      x += mesh.X[static_cast<std::size_t>(node)].x() / 4.0;
      row += ", " + tag(node);
    }
    elements[x < 0.5 ? 0 : 1] += row + "\n";
  }
  return nodes + elements[0] + elements[1] + sets[0] + sets[1] + "*NSET, NSET=monitor\n1\n";
}

struct Expected {
  int order;
  FormulationKind formulation;
  Eigen::Vector3d displacement_m;
};

class FemMaterialsReference : public ::testing::TestWithParam<Expected> {};

// 7 digits are printed, of the components; residuals of 1e-8 here and there cost as much.
TEST_P(FemMaterialsReference, TwoMaterialsOneOrthotropicAgreeWithCalculix) {
  const auto& [order, formulation, expected] = GetParam();
  Material near{.density_kg_per_m3 = 1000.0};
  near.orthotropic = {.young_Pa = {1e7, 4e6, 2e6},
                      .poisson = {0.35, 0.3, 0.4},
                      .shear_Pa = {1.5e6, 1.2e6, 1e6},
                      .axes = material_axes({1, 1, 0.5}, {-1, 1, 0}).value()};
  const Material far{.young_Pa = 5e6, .poisson = 0.25, .density_kg_per_m3 = 2000.0};
  Params params;
  params.mesh.file = temporary_file("cut.inp", cut_cantilever());
  params.mesh.order = order;
  params.materials = {{{"near"}, near}, {{"far"}, far}};
  params.formulation = formulation;
  params.micro_step = SimTime(1'000'000);
  params.fixed = {{"fixed"}};
  params.loads = {{.kind = Load::Kind::Nodal, .set = {"end"}, .value = {20, 30, -60}}};
  const Model model(params);
  const StaticResult result = StaticAnalysis(model, {.load_factors = {0.5, 1.0}}).run();
  ASSERT_EQ(result.report.outcome, Outcome::Done) << result.report.message;
  const Eigen::Vector3d u = mean_displacement(model, {"monitor"}, result.steps.back().x);
  EXPECT_LT((u - expected).norm(), 1e-6 * expected.norm()) << u.transpose();
}

INSTANTIATE_TEST_SUITE_P(
    Cases, FemMaterialsReference,
    ::testing::Values(
        Expected{1, FormulationKind::Linear, {6.314416e-04, 2.387222e-01, -4.731251e-01}},
        Expected{1, FormulationKind::TotalLagrangian, {-9.124505e-02, 1.728448e-01, -3.431101e-01}},
        Expected{2, FormulationKind::Linear, {6.421031e-04, 2.998726e-01, -5.974935e-01}},
        Expected{
            2, FormulationKind::TotalLagrangian, {-1.228545e-01, 1.979619e-01, -3.945875e-01}}));

}  // namespace
}  // namespace tandem::fem
