#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "fem_process/elements/corotational_tet4.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;
using Sparse = Eigen::SparseMatrix<double>;

struct Assembled {
  Sparse K, M;
};

/// Stiffness at rest and mass of the free nodes, as plain sparse matrices.
Assembled assemble(const Model& model) {
  Eigen::VectorXd f;
  BlockValues K;
  model.formulation->evaluate(model.reference(), f, K);
  std::vector<Eigen::Triplet<double>> k;
  std::vector<Eigen::Triplet<double>> m;
  const BlockPattern& pattern = model.interior.pattern;
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int b = pattern.row_start[static_cast<std::size_t>(i)];
         b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
      const int j = pattern.column[static_cast<std::size_t>(b)];
      const int source = model.interior.source[static_cast<std::size_t>(b)];
      for (int r = 0; r < 3; ++r) {
        m.emplace_back(3 * i + r, 3 * j + r, model.mass[static_cast<std::size_t>(source)]);
        for (int c = 0; c < 3; ++c) k.emplace_back(3 * i + r, 3 * j + c, block(K, source)(r, c));
      }
    }
  }
  const Eigen::Index n = 3 * pattern.rows();
  Assembled assembled{Sparse(n, n), Sparse(n, n)};
  assembled.K.setFromTriplets(k.begin(), k.end());
  assembled.M.setFromTriplets(m.begin(), m.end());
  return assembled;
}

/// Lowest frequencies (Hz) of K φ = ω² M φ by subspace iteration with Rayleigh-Ritz [Bathe 1996].
Eigen::VectorXd frequencies(const Model& model, int count) {
  const Assembled a = assemble(model);
  const Eigen::SimplicialLDLT<Sparse> factor(a.K);
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(a.K.rows(), 3 * count);
  for (Eigen::Index i = 0; i < X.size(); ++i) X(i) = std::sin(1.0 + 0.7 * static_cast<double>(i));
  Eigen::VectorXd last = Eigen::VectorXd::Zero(count);
  for (int k = 0; k < 200; ++k) {
    X = factor.solve(a.M * X);
    const Eigen::MatrixXd k_small = X.transpose() * (a.K * X);
    const Eigen::MatrixXd m_small = X.transpose() * (a.M * X);
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> ritz(k_small, m_small);
    X = X * ritz.eigenvectors();
    const Eigen::VectorXd values = ritz.eigenvalues().head(count);
    if ((values - last).cwiseAbs().maxCoeff() < 1e-12 * values.maxCoeff()) break;
    last = values;
  }
  return last.cwiseSqrt() / (2 * M_PI);
}

struct FrequencyCase {
  std::string mesh;
  MassKind mass;
  std::array<double, 10> expected_Hz;
};

class FemFrequencies : public ::testing::TestWithParam<FrequencyCase> {};

// Reference: an independent numpy/scipy program on the same meshes, values printed to 7 digits; its
// stiffness and eigensolver agree with CalculiX to all printed digits.
TEST_P(FemFrequencies, AgreeWithAnIndependentProgram) {
  const bool lug = GetParam().mesh == "lug.msh";
  Params params;
  params.mesh = {.file = data_file(GetParam().mesh), .length_scale_m = lug ? 1e-3 : 1.0};
  params.material = lug ? Material{2.1e11, 0.3, 7850.0} : Material{1e7, 0.3, 1000.0};
  params.mass = GetParam().mass;
  params.fixed = {{"fixed"}};
  params.micro_step = SimTime(1'000'000);
  const Eigen::VectorXd found = frequencies(Model(params), 10);
  for (int i = 0; i < 10; ++i) {
    const double expected = GetParam().expected_Hz[static_cast<std::size_t>(i)];
    EXPECT_NEAR(found(i), expected, 1e-6 * expected) << "mode " << i + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Meshes, FemFrequencies,
    ::testing::Values(FrequencyCase{"cantilever_c1.msh",
                                    MassKind::Consistent,
                                    {2.161947, 2.195094, 12.9016, 12.97524, 23.26001, 25.15722,
                                     33.28916, 33.55701, 60.52298, 60.86485}},
                      FrequencyCase{"cantilever_c1.msh",
                                    MassKind::Lumped,
                                    {2.15756, 2.190758, 12.73878, 12.8147, 18.18355, 25.14243,
                                     32.46925, 32.70338, 53.72529, 58.21085}},
                      FrequencyCase{"cantilever_c2.msh",
                                    MassKind::Consistent,
                                    {1.797093, 1.801555, 10.75674, 10.78165, 17.75118, 25.12256,
                                     28.30236, 28.33278, 51.45218, 51.5549}},
                      FrequencyCase{"cantilever_c2.msh",
                                    MassKind::Lumped,
                                    {1.795794, 1.800253, 10.70778, 10.73206, 16.2521, 25.1168,
                                     28.02652, 28.05153, 48.54078, 50.62227}},
                      FrequencyCase{"cantilever_c3.msh",
                                    MassKind::Consistent,
                                    {1.717816, 1.72355, 10.29038, 10.32101, 16.39364, 25.10632,
                                     27.13102, 27.18694, 49.21568, 49.2603}},
                      FrequencyCase{"cantilever_c3.msh",
                                    MassKind::Lumped,
                                    {1.717183, 1.722917, 10.26593, 10.29636, 15.59864, 25.10354,
                                     26.99373, 27.04857, 46.83042, 48.82764}},
                      FrequencyCase{"lug.msh",
                                    MassKind::Consistent,
                                    {1310.75, 4587.41, 7159.245, 7247.785, 17621.18, 17891.73,
                                     18793.54, 20173.65, 33266.9, 35128.92}},
                      FrequencyCase{"lug.msh",
                                    MassKind::Lumped,
                                    {1307.631, 4571.533, 6949.489, 7115.112, 17104.76, 17620.25,
                                     18764.01, 19211.3, 31397.0, 32803.08}}));

// Node by node: the co-rotational force that an independent 20-line element code finds at
// CalculiX's printed displacements (no solver in between). Forces are printed to 9 digits.
TEST(FemForces, AgreeWithAnIndependentProgramOnTheDeformedLug) {
  const TetMesh mesh = read_mesh({.file = data_file("lug.msh"), .length_scale_m = 1e-3});
  std::map<std::int64_t, int> index;
  for (int i = 0; i < mesh.nodes(); ++i) index[mesh.node_tags[static_cast<std::size_t>(i)]] = i;
  const CorotationalTet4 formulation(mesh, {2.1e11, 0.3, 7850.0});
  Eigen::VectorXd x(3 * mesh.nodes());
  Eigen::VectorXd expected(3 * mesh.nodes());
  std::ifstream csv(data_file("lug_fields.csv"));
  std::string line;
  std::getline(csv, line);
  ASSERT_EQ(line.substr(0, 11), "node,X,Y,Z,");
  int rows = 0;
  for (; std::getline(csv, line); ++rows) {
    std::stringstream fields(line);
    std::array<double, 16> value{};
    std::string field;
    for (double& v : value) {
      std::getline(fields, field, ',');
      v = std::stod(field);
    }
    const int i = index.at(static_cast<std::int64_t>(value[0]));
    for (int c = 0; c < 3; ++c) {
      const auto k = static_cast<std::size_t>(c);
      x(3 * i + c) = mesh.X[static_cast<std::size_t>(i)](c) + 1e-3 * value[7 + k];
      expected(3 * i + c) = value[13 + k];
    }
  }
  ASSERT_EQ(rows, mesh.nodes());
  Eigen::VectorXd f;
  BlockValues K;
  EXPECT_EQ(formulation.evaluate(x, f, K), 0);
  EXPECT_LT((f - expected).cwiseAbs().maxCoeff(), 1e-8 * expected.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace tandem::fem
