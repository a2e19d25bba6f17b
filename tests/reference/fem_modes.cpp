#include <gtest/gtest.h>

#include <array>

#include "fem_process/reduced/modal_analysis.h"
#include "protocol/contract/error.h"
#include "tests/support/fem_reference_cases.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

struct Expected {
  std::string mesh;
  MassKind mass;
  std::array<double, 10> frequencies_Hz;
};

class FemModes : public ::testing::TestWithParam<Expected> {};

// An independent numpy/scipy program, values printed to 7 digits.
TEST_P(FemModes, FrequenciesAgreeWithAnIndependentProgram) {
  Params params = reference_case(GetParam().mesh).params;
  params.mass = GetParam().mass;
  const Model model(std::move(params));
  const Modes modes = lowest_modes(model, 10);
  for (int i = 0; i < 10; ++i) {
    const double expected = GetParam().frequencies_Hz[static_cast<std::size_t>(i)];
    EXPECT_NEAR(modes.frequencies_Hz(i), expected, 1e-6 * expected) << "mode " << i + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Cases, FemModes,
    ::testing::Values(Expected{"beam15",
                               MassKind::Consistent,
                               {3.214993, 3.333416, 13.95087, 15.92217, 17.55282, 25.82168,
                                38.58094, 43.95531, 46.03887, 76.82146}},
                      Expected{"beam15",
                               MassKind::Lumped,
                               {3.084195, 3.168774, 12.09588, 13.61962, 14.20955, 14.74423,
                                24.96481, 27.38036, 37.01258, 40.17706}},
                      Expected{"cantilever_c1",
                               MassKind::Consistent,
                               {2.161947, 2.195094, 12.9016, 12.97524, 23.26001, 25.15722, 33.28916,
                                33.55701, 60.52298, 60.86485}},
                      Expected{"cantilever_c1",
                               MassKind::Lumped,
                               {2.15756, 2.190758, 12.73878, 12.8147, 18.18355, 25.14243, 32.46925,
                                32.70338, 53.72529, 58.21085}},
                      Expected{"cantilever_c2",
                               MassKind::Consistent,
                               {1.797093, 1.801555, 10.75674, 10.78165, 17.75118, 25.12256,
                                28.30236, 28.33278, 51.45218, 51.5549}},
                      Expected{"cantilever_c2",
                               MassKind::Lumped,
                               {1.795794, 1.800253, 10.70778, 10.73206, 16.2521, 25.1168, 28.02652,
                                28.05153, 48.54078, 50.62227}},
                      Expected{"cantilever_c3",
                               MassKind::Consistent,
                               {1.717816, 1.72355, 10.29038, 10.32101, 16.39364, 25.10632, 27.13102,
                                27.18694, 49.21568, 49.2603}},
                      Expected{"cantilever_c3",
                               MassKind::Lumped,
                               {1.717183, 1.722917, 10.26593, 10.29636, 15.59864, 25.10354,
                                26.99373, 27.04857, 46.83042, 48.82764}},
                      Expected{"hinge",
                               MassKind::Consistent,
                               {248.5741, 898.8299, 1468.483, 1568.394, 2339.958, 4008.046,
                                6049.574, 6285.431, 9189.48, 9877.006}},
                      Expected{"hinge",
                               MassKind::Lumped,
                               {248.4503, 898.2931, 1457.424, 1556.47, 2333.486, 3991.63, 5967.412,
                                6253.877, 9034.017, 9791.125}},
                      Expected{"lug",
                               MassKind::Consistent,
                               {1310.75, 4587.41, 7159.245, 7247.785, 17621.18, 17891.73, 18793.54,
                                20173.65, 33266.9, 35128.92}},
                      Expected{"lug",
                               MassKind::Lumped,
                               {1307.631, 4571.533, 6949.489, 7115.112, 17104.76, 17620.25,
                                18764.01, 19211.3, 31397.0, 32803.08}}));

// Six motions without strain, one eigenvalue six times: all of them, and then the first bending
// mode. Zero within the square root of round-off: f_max √ε with f_max below 1e4 Hz times 1e-3.
TEST(FemModes, OfAFreeBodyBeginWithItsSixRigidMotions) {
  Params params = bar_with_two_ports();
  params.ports.clear();
  const Model model(std::move(params));
  const Modes modes = lowest_modes(model, 8);
  EXPECT_LT(modes.frequencies_Hz(5), 1e-4);
  EXPECT_GT(modes.frequencies_Hz(6), 1.0);
}

// φᵀ M φ = I and K φ = ω² M φ. The residual of the iteration is 1e-12 of the eigenvalue.
TEST(FemModes, AreOrthonormalInTheMass) {
  const Model model(reference_case("cantilever_c1").params);
  const Modes modes = lowest_modes(model, 12);
  Eigen::VectorXd f;
  BlockValues K;
  model.formulation->evaluate(model.reference(), f, K);
  for (Eigen::Index i = 0; i < 12; ++i) {
    const Eigen::VectorXd phi = modes.shapes.col(i);
    const Eigen::VectorXd M_phi = multiply_scalar(model.pattern(), model.mass, phi);
    for (Eigen::Index j = 0; j < 12; ++j) {
      EXPECT_NEAR(modes.shapes.col(j).dot(M_phi), i == j ? 1.0 : 0.0, 1e-10);
    }
    const double omega = 2 * M_PI * modes.frequencies_Hz(i);
    EXPECT_NEAR(phi.dot(multiply(model.pattern(), K, phi)), omega * omega, 1e-9 * omega * omega);
    for (int node : model.fixed) EXPECT_EQ(phi.segment<3>(3 * node).norm(), 0.0);
  }
}

TEST(FemModes, RefusesAsManyModesAsFreeDisplacements) {
  const Model model(reference_case("beam15").params);
  EXPECT_NO_THROW(static_cast<void>(lowest_modes(model, 35)));
  EXPECT_THROW(static_cast<void>(lowest_modes(model, 36)), Error);
}

}  // namespace
}  // namespace tandem::fem
