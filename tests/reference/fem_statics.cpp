#include <gtest/gtest.h>

#include "fem_process/transient/static_analysis.h"
#include "protocol/contract/error.h"
#include "tests/support/fem_reference_cases.h"

namespace tandem::fem {
namespace {

using namespace testing;

StaticResult solve(const ReferenceCase& reference, FormulationKind formulation,
                   const StaticParams& params) {
  Params model = reference.params;
  model.formulation = formulation;
  const Model built(std::move(model));
  return StaticAnalysis(built, params).run();
}

Eigen::Vector3d displacement(const ReferenceCase& reference, const Eigen::VectorXd& x) {
  return mean_displacement(Model(reference.params), reference.monitor, x);
}

struct Claim {
  std::string mesh;
  FormulationKind formulation;
};

class FemStatics : public ::testing::TestWithParam<Claim> {};

// At every load level, relative to the norm of the displacement. The references are printed to 7
// digits, the smallest component 1e-3 of the norm: 1e-6 leaves room for the printing alone; the
// residual of 1e-8 costs about as much in displacement.
TEST_P(FemStatics, AgreeWithIndependentProgramsAtEveryLoadLevel) {
  const auto& [mesh, formulation] = GetParam();
  const ReferenceCase reference = reference_case(mesh);
  const StaticResult result = solve(reference, formulation, {.load_factors = reference.factors()});
  ASSERT_EQ(result.report.outcome, Outcome::Done) << result.report.message;
  ASSERT_EQ(result.steps.size(), reference.steps.size());
  for (std::size_t k = 0; k < result.steps.size(); ++k) {
    const ReferenceStep& step = reference.steps[k];
    const Eigen::Vector3d& expected = formulation == FormulationKind::Linear ? step.linear
                                      : formulation == FormulationKind::TotalLagrangian
                                          ? step.nlgeom
                                          : step.corot;
    const Eigen::Vector3d found = displacement(reference, result.steps[k].x);
    EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm()) << "load factor " << step.factor;
    EXPECT_EQ(result.steps[k].inverted_elements, 0);
  }
}

std::vector<Claim> claims() {
  std::vector<Claim> claims;
  for (const char* mesh :
       {"hinge", "lug", "beam15", "cantilever_c1", "cantilever_c2", "cantilever_c3"}) {
    for (FormulationKind kind :
         {FormulationKind::Linear, FormulationKind::Corotational,
          FormulationKind::ConsistentCorotational, FormulationKind::TotalLagrangian}) {
      claims.push_back({mesh, kind});
    }
  }
  return claims;
}
INSTANTIATE_TEST_SUITE_P(Cases, FemStatics, ::testing::ValuesIn(claims()));

// The plain iteration of [MZ12] takes as many solves as in an independent program (residual 1e-6);
// one more or less where a residual falls on the tolerance.
TEST(FemStaticIteration, PlainSimplifiedTangentConvergesAsInAnIndependentProgram) {
  const ReferenceCase reference = reference_case("hinge");
  const StaticResult result =
      solve(reference, FormulationKind::Corotational,
            {.load_factors = reference.factors(), .tolerance = 1e-6, .safeguards = false});
  const std::vector<int> expected{4, 5, 5, 6,  6,  6,  6,  7,  7,  8,
                                  8, 9, 9, 10, 10, 11, 11, 12, 13, 14};
  ASSERT_EQ(result.steps.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_NEAR(result.steps[k].iterations, expected[k], 1) << "load level " << k + 1;
  }
}

// Three times the load of the reference in one step, far past where the simplified tangent's plain
// iteration diverges: with line search and cuts it comes to the equilibrium that Newton finds.
// Residuals of 1e-8 leave about 1e-7 in displacement.
TEST(FemStaticIteration, SafeguardsCarryTheSimplifiedTangentWhereThePlainIterationFails) {
  const ReferenceCase reference = reference_case("cantilever_c2");
  const StaticParams far{.load_factors = {3.0}};
  StaticParams plain = far;
  plain.safeguards = false;
  EXPECT_EQ(solve(reference, FormulationKind::Corotational, plain).report.outcome,
            Outcome::NotConverged);
  const StaticResult simplified = solve(reference, FormulationKind::Corotational, far);
  const StaticResult consistent = solve(reference, FormulationKind::ConsistentCorotational, far);
  ASSERT_EQ(simplified.report.outcome, Outcome::Done) << simplified.report.message;
  ASSERT_EQ(consistent.report.outcome, Outcome::Done) << consistent.report.message;
  EXPECT_TRUE(simplified.steps[0].searched);
  EXPECT_LT(consistent.steps[0].iterations, 15);
  const Eigen::Vector3d u = displacement(reference, consistent.steps[0].x);
  EXPECT_GT(u.norm(), 0.7);  // the beam is 1 m long
  EXPECT_LT((displacement(reference, simplified.steps[0].x) - u).norm(), 1e-6 * u.norm());
}

// One equilibrium iteration squares the error: residuals 1e-3 → 1e-6 → 1e-12 of the load. Within
// one load step of the hinge, tolerances of 1e-4 and 1e-10 are at most two solves apart, while a
// linearly converging iteration needs more than that for six orders of magnitude.
TEST(FemStaticIteration, ConsistentTangentsConvergeQuadratically) {
  const ReferenceCase reference = reference_case("hinge");
  for (FormulationKind kind :
       {FormulationKind::ConsistentCorotational, FormulationKind::TotalLagrangian}) {
    const StaticResult coarse =
        solve(reference, kind, {.load_factors = {0.25, 0.5, 0.75, 1.0}, .tolerance = 1e-4});
    const StaticResult fine =
        solve(reference, kind, {.load_factors = {0.25, 0.5, 0.75, 1.0}, .tolerance = 1e-10});
    ASSERT_EQ(coarse.steps.size(), 4U);
    ASSERT_EQ(fine.steps.size(), 4U);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_LE(fine.steps[k].iterations, coarse.steps[k].iterations + 2);
    }
  }
}

// The first step takes 5 solves (table of the reference): 2 are too few, and it is said.
TEST(FemStaticIteration, TooFewIterationsAreReportedAsNotConverged) {
  const ReferenceCase reference = reference_case("cantilever_c1");
  const StaticResult result =
      solve(reference, FormulationKind::Corotational,
            {.load_factors = {0.5, 1.0}, .max_iterations = 2, .safeguards = false});
  EXPECT_EQ(result.report.outcome, Outcome::NotConverged);
  EXPECT_TRUE(result.steps.empty());
  EXPECT_NE(result.report.message.find("load factor 0.5"), std::string::npos);
}

TEST(FemStaticParams, RefusesBadValues) {
  const StaticParams bad[] = {{.load_factors = {}},  {.load_factors = {std::nan("")}},
                              {.tolerance = 0.0},    {.tolerance = 1.0},
                              {.max_iterations = 0}, {.law_time_s = std::nan("")}};
  for (const StaticParams& params : bad) EXPECT_THROW(check(params), Error);
}

}  // namespace
}  // namespace tandem::fem
