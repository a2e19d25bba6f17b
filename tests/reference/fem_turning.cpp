#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <tuple>

#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

// A steel bar of four unit cubes that turns at a constant rate about its clamped end, against the
// static centrifugal solution on the same mesh, K u = ω² M X, and closed forms of a turning body.
constexpr double kRate_rad_per_s = 20.0;
const Eigen::Vector3d kAxisPoint(0.0, 0.5, 0.5);

Params bar(const IntegratorParams& integrator, FormulationKind formulation, int order,
           double turn_rad) {
  static const std::filesystem::path file = temporary_file("turning.inp", box_inp(4));
  Params params;
  params.mesh.file = file;
  params.mesh.order = order;
  params.formulation = formulation;
  params.integrator = integrator;
  params.material = {.young_Pa = 2.1e11, .poisson = 0.3, .density_kg_per_m3 = 7850.0};
  params.damping.beta_s = 1e-3;
  params.ports = {{"hub", {"LEFT"}, kAxisPoint}};
  params.initial_velocity = {.angular_rad_per_s = {0.0, 0.0, kRate_rad_per_s},
                             .about_m = kAxisPoint};
  params.micro_step = sim_time_from_seconds(turn_rad / kRate_rad_per_s);
  return params;
}

MotionSet hub(double t) {
  const Eigen::Vector3d w(0.0, 0.0, kRate_rad_per_s);
  return {{.p_WP = kAxisPoint, .q_WP = rotation(w * t), .w_WP = w}};
}

struct Static {
  double extension_m = 0.0;
  double force_N = 0.0;    ///< m ω² r_c
  double kinetic_J = 0.0;  ///< ½ ω² J
};

/// From M and K of the reference alone, densely.
Static centrifugal(const Model& model) {
  const double w2 = kRate_rad_per_s * kRate_rad_per_s;
  Eigen::VectorXd arm = model.reference();
  for (Eigen::Index i = 0; i < arm.size(); i += 3) {
    arm.segment<3>(i) -= kAxisPoint;
    arm(i + 2) = 0.0;
  }
  const Eigen::VectorXd load = w2 * multiply_scalar(model.pattern(), model.mass, arm);
  Eigen::VectorXd f;
  BlockValues K;
  model.formulation->evaluate(model.reference(), f, K);
  const auto n = 3 * static_cast<Eigen::Index>(model.free.size());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  const BlockPattern& pattern = model.interior.pattern;
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int b = pattern.row_start[static_cast<std::size_t>(i)];
         b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
      dense.block<3, 3>(3 * i, 3 * pattern.column[static_cast<std::size_t>(b)]) =
          block(K, model.interior.source[static_cast<std::size_t>(b)]);
    }
  }
  Eigen::VectorXd rhs(n);
  for (std::size_t k = 0; k < model.free.size(); ++k) {
    rhs.segment<3>(3 * static_cast<Eigen::Index>(k)) = load.segment<3>(3 * model.free[k]);
  }
  const Eigen::VectorXd u = dense.ldlt().solve(rhs);
  Static found;
  const std::vector<int>& tip = find_set(model.mesh, {"RIGHT"}).nodes;
  for (std::size_t k = 0; k < model.free.size(); ++k) {
    if (std::find(tip.begin(), tip.end(), model.free[k]) == tip.end()) continue;
    found.extension_m += u(3 * static_cast<Eigen::Index>(k)) / static_cast<double>(tip.size());
  }
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < load.size(); i += 3) force += load.segment<3>(i);
  found.force_N = force.norm();
  found.kinetic_J = 0.5 * arm.dot(load);
  return found;
}

/// Mean over the tip's nodes of how far they are from the axis along the bar (m).
double reach(const FlexibleBody& body, double t) {
  const std::vector<int>& tip = find_set(body.model().mesh, {"RIGHT"}).nodes;
  const Eigen::Vector3d along =
      rotation(Eigen::Vector3d(0, 0, kRate_rad_per_s * t)) * Eigen::Vector3d::UnitX();
  double sum = 0.0;
  for (int node : tip) {
    const Eigen::Vector3d r = body.state().x.segment<3>(3 * node) - kAxisPoint;
    sum += along.dot(r);
  }
  return sum / static_cast<double>(tip.size());
}

class FemTurning
    : public ::testing::TestWithParam<std::tuple<IntegratorParams, FormulationKind, int>> {};

// Limits: extension 1 % (3 % at half a radian per step), of which the prestress of the strained bar
// takes 1e-4; the end forces of Newmark's family m ω² r_c within 0.1 %; those of backward Euler are
// means over the step's arc, sin(ωh/2)/(ωh/2) of that, to 1e-4; torque 1e-6 of force times length;
// kinetic energy 0.1 %. Dissipative weights let the bar come to rest in turning axes.
TEST_P(FemTurning, KnowsNothingOfTheStepsTurn) {
  const auto& [integrator, formulation, order] = GetParam();
  for (double turn : {0.01, 0.1, 0.3, 0.5}) {
    SCOPED_TRACE(turn);
    const Params params = bar(integrator, formulation, order, turn);
    FlexibleBody body(params);
    const Static expected = centrifugal(body.model());
    body.initialize(hub(0.0));
    const double h = to_seconds(params.micro_step);
    const int steps = turn < 0.05 ? 2000 : 600;
    double extension = 0.0;
    double force = 0.0;
    double torque = 0.0;
    const int last = 100;
    for (int k = 1; k <= steps; ++k) {
      const auto result = body.advance(request(hub((k - 1) * h), hub(k * h), params.micro_step));
      ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
      if (k <= steps - last) continue;
      extension += (reach(body, k * h) - 4.0) / last;
      force += result.output[0].f_P_W.norm() / last;
      torque += result.output[0].t_P_W.z() / last;  // about the shaft
    }
    EXPECT_NEAR(extension / expected.extension_m, 1.0, turn < 0.4 ? 0.01 : 0.03);
    const bool means = integrator.kind == IntegratorKind::BackwardEuler;
    const double mean = means ? std::sin(0.5 * turn) / (0.5 * turn) : 1.0;
    EXPECT_NEAR(force / (mean * expected.force_N), 1.0, means ? 1e-4 : 1e-3);
    EXPECT_LT(std::abs(torque), 1e-6 * expected.force_N * 4.0);
    EXPECT_NEAR(body.observe().energy.kinetic_J / expected.kinetic_J, 1.0, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, FemTurning,
    ::testing::Combine(
        ::testing::Values(
            IntegratorParams{}, IntegratorParams{.kind = IntegratorKind::Hht, .hht_alpha = -0.3},
            IntegratorParams{.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.5}),
        ::testing::Values(FormulationKind::Corotational, FormulationKind::ConsistentCorotational,
                          FormulationKind::TotalLagrangian),
        ::testing::Values(1, 2)));

}  // namespace
}  // namespace tandem::fem
