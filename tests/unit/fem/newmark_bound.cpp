// The bound of Newmark's rule with β = 1/12: the highest frequency of the mesh against all of them,
// and what steps below and above the bound do.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <utility>

#include "fem_process/body/flexible_side.h"
#include "fem_process/keys/fem_keys.h"
#include "fem_process/reduced/highest_frequency.h"
#include "fem_process/sides/make_side.h"
#include "mbs_process/make_side.h"
#include "orchestrator/scenario/model.h"

namespace tandem::orchestrator {
namespace {

constexpr double kBeta = 1.0 / 12.0;

/// The bar of two_masses, whose ends are ports.
Model bar(const std::string& mass) {
  return load_model(std::string(TANDEM_SOURCE_DIR) + "/examples/two_masses/scenario.yaml",
                    {{"fem.mass", mass}, {"fem.formulation", "linear"}});
}

/// All frequencies of the free nodes, from the whole matrices.
double highest_of_all(const fem::Model& model) {
  Eigen::VectorXd f;
  fem::BlockValues K;
  model.formulation->evaluate(model.reference(), f, K);
  const fem::BlockPattern& pattern = model.interior.pattern;
  const Eigen::Index size = 3 * pattern.rows();
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(size, size);
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int b = pattern.row_start[static_cast<std::size_t>(i)];
         b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
      const int j = pattern.column[static_cast<std::size_t>(b)];
      const int source = model.interior.source[static_cast<std::size_t>(b)];
      stiffness.block<3, 3>(3 * i, 3 * j) = fem::block(std::as_const(K), source);
      mass.block<3, 3>(3 * i, 3 * j) =
          model.mass[static_cast<std::size_t>(source)] * Eigen::Matrix3d::Identity();
    }
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solved(stiffness, mass,
                                                                         Eigen::EigenvaluesOnly);
  return std::sqrt(solved.eigenvalues().maxCoeff());
}

// Lanczos' bound of the residual is added: never below, above by less than a hundredth.
TEST(NewmarkBound, FrequencyIsTheHighestOfTheMassInUse) {
  for (const std::string mass : {"consistent", "lumped"}) {
    const fem::Model model(fem::read_params(bar(mass).scenario.root));
    const double all = highest_of_all(model);
    EXPECT_GT(fem::highest_step_frequency(model), all * (1.0 - 1e-9)) << mass;
    EXPECT_LT(fem::highest_step_frequency(model), all * 1.01) << mass;
    if (mass == "lumped") {
      EXPECT_NEAR(fem::highest_angular_frequency(model), all, 0.01 * all);
    }
  }
}

/// Energy after 300 steps of that length with the ports at rest, against that of the start.
double growth_at(const Model& model, double length_s) {
  const SimTime step(std::llround(1e9 * length_s));
  fem::Params params = fem::read_params(model.scenario.root);
  params.integrator.kind = fem::IntegratorKind::Newmark;
  params.integrator.newmark_beta = kBeta;
  params.micro_step = step;
  const auto body = fem::make_body(std::move(params));
  const auto rigid = mbs::make_side(model.scenario.root, {});
  MotionSet held = rigid->initialize(WrenchSet(model.port_names.size()));
  for (Motion& motion : held) motion.v_WP = motion.w_WP = Eigen::Vector3d::Zero();
  (void)body->initialize(held);
  const auto energy_J = [&] {
    const EnergyBook book = body->observe().energy;
    return book.kinetic_J + book.elastic_J;
  };
  const double start_J = energy_J();
  for (int i = 0; i < 300; ++i) {
    const auto result = body->advance({.step = step, .input = {held, held}});
    if (result.outcome != Outcome::Done) return INFINITY;
  }
  return energy_J() / start_J;
}

TEST(NewmarkBound, DividesBoundedFromGrowingMotion) {
  const Model model = bar("consistent");
  const double w = fem::highest_step_frequency(fem::Model(fem::read_params(model.scenario.root)));
  const double limit_s = fem::newmark_step_limit_s(kBeta, 0.5, w);
  EXPECT_NEAR(limit_s * w, std::sqrt(6.0), 1e-12);
  EXPECT_LT(growth_at(model, 0.97 * limit_s), 10.0);
  EXPECT_GT(growth_at(model, 1.03 * limit_s), 1e3);
}

TEST(NewmarkBound, IsNoneForTheTrapezoidalRule) {
  EXPECT_TRUE(std::isinf(fem::newmark_step_limit_s(0.25, 0.5, 1e6)));
  EXPECT_TRUE(std::isfinite(fem::newmark_step_limit_s(0.25, 0.6, 1e6)));
}

}  // namespace
}  // namespace tandem::orchestrator
